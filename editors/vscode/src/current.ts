// The settings as they are now.
import * as vscode from "vscode";
import { settingsFrom, type Settings } from "./settings";

export function current(resource?: vscode.Uri): Settings {
  const configuration = vscode.workspace.getConfiguration("elitescript", resource ?? null);
  return settingsFrom((key) => configuration.get(key));
}
