//! The pendant page on the http port: its files, `/api/v1`, and the live view.
//!
//! Owns the routes and who may use them; what an order is and what a frame looks like is in the crate `pendant`, what
//! the controller answers comes from [`PageBackend`]. The live connections are in `live`, what they are shown comes
//! from `page_broadcast`.

mod debug;
mod files;
mod live;
mod page_broadcast;
mod planned;
mod routes;
mod search;

use std::path::Path;
use std::sync::Arc;

use controller::ControllerConfig;
use elite_runtime::CompilePool;
use elite_runtime::message::Message;
use elite_runtime::task_folder::TaskFolder;
use futures_util::FutureExt as _;
use futures_util::future::BoxFuture;
use hyper::upgrade::OnUpgrade;
use messages::{Localized, Text};
use motion_api::{CommandId, CommandKind, Outcome};
use parking_lot::Mutex;
use pendant::{ControlLock, History, PageOrder, SceneMeshes, Token};
use recorder::Recording;
use serde_json::Value;
use tokio::sync::broadcast;
use tokio_util::sync::CancellationToken;

use super::HttpBackend;
pub use debug::DEBUG_PATH;
pub use live::{LIVE_PATH, shake_hands};
pub use page_broadcast::{
    ALARM_LEVEL, MODE_LEVEL, ModeTracker, PageBroadcast, add_load, line_event, registers_text,
    short, texts_of,
};
pub use routes::router;

/// Texts of pages that wait in the compile pool or are read.
const TEXTS_MAX: usize = 4;

/// The program that is shown: number, name and text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShownProgram {
    /// Number of the program.
    pub number: u32,
    /// Name of the program.
    pub name: String,
    /// Text of the program.
    pub text: Arc<str>,
}

/// What the page asks of a controller, beside what every http client may.
pub trait PageBackend: HttpBackend {
    /// Reason why nothing can be ordered, if so.
    fn read_only(&self) -> Option<Text>;
    /// The hub that debuggers attach to, if they may.
    fn debuggers(&self) -> Option<&Arc<editor::dap::DebugHub>> {
        None
    }
    /// What the page draws.
    fn scene(&self) -> Value;
    /// The meshes that the scene names by number.
    fn meshes(&self) -> &SceneMeshes;
    /// Version, clock, cycle and the like.
    fn about(&self) -> Value;
    /// Line of the main thread, and number of the node of the pendant's task.
    fn place(&self) -> (u32, u32);
    /// Number of the newest program.
    fn program_number(&self) -> u32;
    /// A program by its number, while it is known.
    fn program(&self, number: u32) -> Option<ShownProgram>;
    /// Everything that is told from now on.
    fn subscribe_messages(
        &self,
    ) -> (
        broadcast::Receiver<controller::LogLine>,
        Option<broadcast::Receiver<Message>>,
    );
    /// The world of the cell at this moment, as JSON; the same `Arc` as long as nothing in it changes.
    fn world(&self) -> Option<Arc<str>> {
        None
    }
    /// Carries an order out that is not held; what it answers.
    fn order(&self, order: PageOrder) -> impl Future<Output = Result<Value, Text>> + Send;
    /// A sentence about the arm in which safety planes have the names of the cell.
    fn sentence(&self, about: &impl Localized) -> Text {
        Text::of(about)
    }
    /// Gives the arm a command that is held.
    ///
    /// # Errors
    /// A sentence.
    fn begin_hold(&self, command: CommandKind) -> Result<CommandId, Text>;
    /// Ends what is held; never refused.
    fn end_hold(&self, command: CommandKind);
    /// How a command ended, once.
    fn outcome(&self, id: CommandId) -> Option<Outcome>;
    /// Nobody asks for that any more.
    fn forget(&self, id: CommandId);
    /// Joint positions near the arm's at which the TCP has a pose: x, y, z, Rx, Ry, Rz.
    ///
    /// # Errors
    /// A sentence.
    fn reach(&self, pose: [f64; 6]) -> Result<[f64; 6], Text>;
    /// Whether the arm may be asked to be at joint positions.
    ///
    /// # Errors
    /// A sentence.
    fn check_joint_target(&self, joints: [f64; 6]) -> Result<[f64; 6], Text>;
    /// The programs, and where they are.
    fn tasks(&self) -> Option<(&TaskFolder, &Path)>;
    /// Settings of an arm that stands as this one does, for a program that is run beside it and reaches nothing
    /// outside.
    ///
    /// # Errors
    /// A sentence: nothing can be run here.
    fn rehearsal(&self) -> Result<ControllerConfig, Text>;
    /// The pool that compiles texts, shared with the ports.
    fn compile_pool(&self) -> &CompilePool;
    /// The recording that is shown, or being made.
    ///
    /// # Errors
    /// A sentence: there is none, or it cannot be opened.
    fn recording(&self) -> Result<Recording, Text>;
    /// The history of a recording; a controller that runs has one that the stage fills.
    fn recorded(&self) -> Option<Arc<Mutex<History>>> {
        None
    }
}

/// The page of one controller: who is at the desk, what was, what is.
pub struct Page<C> {
    cockpit: Arc<C>,
    token: Token,
    /// Whoever asks gets the token: only with a port that only this machine reaches.
    token_is_public: bool,
    desk: Mutex<ControlLock>,
    stage: Arc<PageBroadcast>,
    /// One search through a recording at a time.
    searching: tokio::sync::Semaphore,
    /// One program beside the robot at a time.
    planning: tokio::sync::Semaphore,
    /// Bounds the texts of pages in the compile pool, which leaves room there for those of programs.
    reading: tokio::sync::Semaphore,
}

impl<C: PageBackend> Page<C> {
    /// The page of a controller. With `token_is_public` the token is given to whoever may ask here.
    ///
    /// # Errors
    /// The operating system gives no random numbers.
    pub fn new(cockpit: Arc<C>, is_given: bool) -> std::io::Result<Self> {
        let history = cockpit.recorded().unwrap_or_default();
        Ok(Self {
            stage: Arc::new(PageBroadcast::new(history)),
            cockpit,
            token: Token::random()?,
            token_is_public: is_given,
            desk: Mutex::default(),
            searching: tokio::sync::Semaphore::new(1),
            planning: tokio::sync::Semaphore::new(1),
            reading: tokio::sync::Semaphore::new(TEXTS_MAX),
        })
    }

    /// What orders must carry.
    pub const fn token(&self) -> &Token {
        &self.token
    }

    /// What pages are shown.
    pub const fn stage(&self) -> &Arc<PageBroadcast> {
        &self.stage
    }

    /// Shows what happens until `shutdown`.
    pub async fn run(&self, shutdown: &CancellationToken) {
        tokio::join!(
            self.stage.run(&*self.cockpit, shutdown),
            debug::tell(self, shutdown)
        );
    }

    /// Tells every page who has control.
    fn tell_control(&self) {
        let holder = self.desk.lock().holder();
        let control = serde_json::json!({"event": "control", "page": holder.map(|page| page.0)});
        self.stage.tell(control.to_string().into());
    }
}

/// A page's connection, whichever controller it shows.
pub trait LiveEndpoint: Send + Sync {
    /// Serves one page until it leaves or `shutdown`.
    fn attend<'a>(
        &'a self,
        upgrade: OnUpgrade,
        shutdown: &'a CancellationToken,
    ) -> BoxFuture<'a, ()>;

    /// Serves one debugger until it leaves or `shutdown`.
    fn debug<'a>(
        &'a self,
        upgrade: OnUpgrade,
        shutdown: &'a CancellationToken,
    ) -> BoxFuture<'a, ()>;
}

impl<C: PageBackend> LiveEndpoint for Page<C> {
    fn attend<'a>(
        &'a self,
        upgrade: OnUpgrade,
        shutdown: &'a CancellationToken,
    ) -> BoxFuture<'a, ()> {
        live::attend(self, upgrade, shutdown).boxed()
    }

    fn debug<'a>(
        &'a self,
        upgrade: OnUpgrade,
        shutdown: &'a CancellationToken,
    ) -> BoxFuture<'a, ()> {
        debug::attend(self, upgrade, shutdown).boxed()
    }
}
