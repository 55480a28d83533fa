//! `eliteserver lsp`: the language server on standard input and output.

use std::io::{stdin, stdout};

use editor::analysis::words::Language;
use editor::lsp::{LspSessionEnd, ServerOptions, serve};

use crate::cli::LspArgs;
use crate::command::{CommandResult, CommandStatus};

/// Exit status: 0 after `shutdown` and `exit`, 1 when the client went without a word.
///
/// # Errors
/// A sentence: the client takes no answers.
pub fn lsp(args: &LspArgs) -> CommandResult {
    let options = ServerOptions {
        language: args.log.language.map(Language::from),
        client: args.client,
        follow_client: true,
    };
    let end = serve(stdin(), &mut stdout().lock(), &options)?;
    Ok(CommandStatus::of_answer(end == LspSessionEnd::Orderly))
}
