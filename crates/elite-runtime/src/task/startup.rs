//! How the program of a task begins: it is compiled, finds its presets, and has its first thread.
//!
//! Stops are heard meanwhile. What happens from then on is the scheduler's.

use std::sync::Arc;

use elite_lang::{Resume, ResumeOutcome};
use elite_syntax::{Diagnostic, Program, ProgramKind, SourceFile};
use io_bus::ProgramState;
use messages::text;
use motion_api::ThreadNumber;

use super::scheduler::{FUEL_PER_SLICE, ProgramSource, Task, TaskEnd};
use crate::external::ExternalInputKind;
use crate::message::Message;
use crate::supervisor::is_secondary;

/// Slices that the value of one preset may take.
const SLICES_OF_PRESET: u32 = 100;

impl Task {
    pub(super) async fn run_program(&mut self, program: ProgramSource) -> TaskEnd {
        let compiled = match program {
            ProgramSource::Compiled(program) => Ok(program),
            ProgramSource::Text(text) => {
                let file = SourceFile::new(text.name, text.text);
                match self.compile(&file).await {
                    Some(compiled) => compiled.map_err(|findings| (findings, file)),
                    None => return self.progress.end.clone().unwrap_or(TaskEnd::Stopped),
                }
            }
        };
        match compiled {
            Ok(program) => {
                if program.kind() == ProgramKind::Main
                    && let Err(end) = self.set_presets()
                {
                    return end;
                }
                if let Some(attached) = self.debugger.clone() {
                    self.interpreter.debug(attached);
                }
                self.begin_turns();
                self.start_program(ThreadNumber(0), &program);
                let text = program.file().text();
                self.settings
                    .observer
                    .program_compiled(self.context.program(), text);
                self.context.interpreter().task_runs(&program);
                // A program compiled on another thread was never in the account, and what runs is in it by now.
                task_memory::uncounted(|| drop(program));
                self.program_is(ProgramState::Running);
                let end = self.run_threads().await;
                self.context.note(ExternalInputKind::Ends);
                end
            }
            Err((findings, file)) => {
                let secondary = is_secondary(file.text());
                for finding in &findings {
                    self.report_finding(finding, &file, secondary);
                }
                TaskEnd::NotCompiled
            }
        }
    }

    /// Sets the globals that the program is to find; one that cannot be worked out ends the task.
    fn set_presets(&mut self) -> Result<(), TaskEnd> {
        for preset in self.presets.clone().iter() {
            let file = SourceFile::new("--set", format!("{}\n", preset.statement()));
            let program = elite_syntax::compile(file.clone(), &self.known).map_err(|findings| {
                for finding in &findings {
                    self.report_finding(finding, &file, false);
                }
                TaskEnd::NotCompiled
            })?;
            let mut script = self.interpreter.spawn_program(&program);
            let mut slices = 0;
            loop {
                slices += 1;
                match script.resume(Resume::Continue, FUEL_PER_SLICE) {
                    ResumeOutcome::Done(_) => break,
                    ResumeOutcome::OutOfFuel if slices < SLICES_OF_PRESET => {}
                    ResumeOutcome::Failed(error) => {
                        self.report_script_error(&error);
                        return Err(TaskEnd::Failed);
                    }
                    _ => {
                        let summary = text!(
                            "TimeoutError: --set {}: a value cannot wait",
                            "TimeoutError: --set {}：值不能等待",
                            preset.name()
                        );
                        self.settings.observer.message(&Message::ScriptError {
                            program: self.context.program(),
                            line: 1,
                            column: 1,
                            report: summary.clone(),
                            summary,
                        });
                        return Err(TaskEnd::Failed);
                    }
                }
            }
        }
        Ok(())
    }

    /// Compiles the program of the task on the threads for that, so that a stop does not wait for a long text; `None`
    /// when one comes before. Where there is no thread for it now, this one does it.
    async fn compile(
        &mut self,
        file: &Arc<SourceFile>,
    ) -> Option<Result<Program, Vec<Diagnostic>>> {
        let compiler = self.context.interpreter().clone();
        let compiling = compiler.compile(file.clone());
        tokio::pin!(compiling);
        let compiled = loop {
            let order = tokio::select! {
                biased;
                order = self.controls.next_order() => order,
                compiled = &mut compiling => break compiled,
            };
            self.note_order(&order);
            self.apply_control(order);
            if self.progress.end.is_some() {
                return None;
            }
        };
        Some(compiled.unwrap_or_else(|_| elite_syntax::compile(file.clone(), &self.known)))
    }
}
