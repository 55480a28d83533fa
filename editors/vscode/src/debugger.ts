// The debugger of programs and recordings.
import * as vscode from "vscode";
import { current } from "./current";
import { debugAdapter, launchKeys } from "./settings";

export const DEBUG_TYPE = "eliteserver";

export function registerDebugger(context: vscode.ExtensionContext): void {
  context.subscriptions.push(
    vscode.debug.registerDebugAdapterDescriptorFactory(DEBUG_TYPE, {
      createDebugAdapterDescriptor: (session) => {
        const { command, args } = debugAdapter(current(session.workspaceFolder?.uri));
        const folder = session.workspaceFolder?.uri.fsPath;
        return new vscode.DebugAdapterExecutable(command, [...args], folder === undefined ? {} : { cwd: folder });
      },
    }),
    vscode.debug.registerDebugConfigurationProvider(DEBUG_TYPE, {
      resolveDebugConfiguration: (folder, configuration) => {
        const editor = vscode.window.activeTextEditor;
        // F5 without a launch.json: the program in the editor.
        if (configuration.type === "" && editor?.document.languageId === "elitescript") {
          return launch(editor.document.uri, folder?.uri);
        }
        if (configuration["program"] === undefined && configuration["recording"] === undefined) {
          void vscode.window.showErrorMessage("EliteScript: the launch configuration needs program or recording.");
          return undefined;
        }
        return configuration;
      },
    }),
  );
}

/** The launch configuration of a program, with the options of the settings. */
export function launch(file: vscode.Uri, folder?: vscode.Uri): vscode.DebugConfiguration {
  return {
    ...launchKeys(current(folder ?? file).runOptions),
    type: DEBUG_TYPE,
    request: "launch",
    name: "Robot program",
    program: file.fsPath,
    stopAtEnd: true,
  };
}
