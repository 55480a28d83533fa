// Where the editor begins and ends the extension.
import * as vscode from "vscode";
import { registerCommands } from "./commands";
import { registerDebugger } from "./debugger";
import { LanguageServer } from "./server";

let server: LanguageServer | undefined;

export async function activate(context: vscode.ExtensionContext): Promise<void> {
  const output = vscode.window.createOutputChannel("EliteScript", { log: true });
  context.subscriptions.push(output);
  server = new LanguageServer(output);
  registerCommands(context, output, server);
  registerDebugger(context);
  context.subscriptions.push(
    vscode.workspace.onDidChangeConfiguration((change) => {
      const matters = ["elitescript.path", "elitescript.language"].some((key) => change.affectsConfiguration(key));
      if (matters) void server?.restart();
    }),
  );
  await server.start();
}

export async function deactivate(): Promise<void> {
  await server?.stop();
}
