// The language server: started, started again, ended with the editor.
import * as vscode from "vscode";
import {
  LanguageClient,
  type Executable,
  type LanguageClientOptions,
  type ServerOptions,
} from "vscode-languageclient/node";
import { current } from "./current";
import { languageServer } from "./settings";

export class LanguageServer {
  private client: LanguageClient | undefined;

  constructor(private readonly output: vscode.LogOutputChannel) {}

  async start(): Promise<void> {
    const { command, args } = languageServer(current());
    // Without a transport the client adds no argument of its own.
    const program: Executable = { command, args: [...args] };
    const server: ServerOptions = { run: program, debug: program };
    const options: LanguageClientOptions = {
      documentSelector: [{ language: "elitescript" }],
      outputChannel: this.output,
    };
    this.client = new LanguageClient("elitescript", "EliteScript", server, options);
    try {
      await this.client.start();
    } catch (error) {
      this.client = undefined;
      await notFound(command, error);
    }
  }

  async stop(): Promise<void> {
    const client = this.client;
    this.client = undefined;
    await client?.stop();
  }

  async restart(): Promise<void> {
    await this.stop();
    await this.start();
  }
}

/** Says that the program does not start, and leads to the setting. */
export async function notFound(command: string, error: unknown): Promise<void> {
  const why = error instanceof Error ? error.message : String(error);
  const settings = "Open Settings";
  const chosen = await vscode.window.showErrorMessage(`EliteScript: cannot start ${command}: ${why}`, settings);
  if (chosen === settings) await vscode.commands.executeCommand("workbench.action.openSettings", "elitescript.path");
}
