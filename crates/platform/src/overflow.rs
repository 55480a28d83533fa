//! Native stacks that overflow: the thread goes on elsewhere instead of ending the process.
//!
//! Owns the handler of SIGSEGV, which looks at the thread that met the guard page at the end of a stack and has it go
//! on in its refuge, and hands every other fault to who handled them before. A thread without a refuge ends the process
//! as ever. Where the system is not Linux on x86-64 or ARM64, none has one.

/// Where a thread goes on, once, when the stack that it is on overflows.
#[derive(Clone, Copy, Debug)]
pub struct Refuge {
    /// The highest address of a stack that nobody uses.
    pub stack: usize,
    /// What runs there. The frames of the stack that has overflowed stay as they are, for ever: none of them goes on.
    pub run: extern "C" fn() -> !,
}

pub use imp::{change_refuge, touch_ahead};

#[cfg(all(
    target_os = "linux",
    any(target_arch = "x86_64", target_arch = "aarch64")
))]
mod imp {
    use std::cell::{Cell, OnceCell};
    use std::ffi::{c_int, c_void};
    use std::ptr;
    use std::sync::OnceLock;

    use super::Refuge;
    use crate::memory::{self, PAGE};

    thread_local! {
        // Neither initialised nor dropped: the handler may look at it whenever the thread runs.
        static REFUGE: Cell<Option<Refuge>> = const { Cell::new(None) };
        static ALTERNATE: OnceCell<Alternate> = const { OnceCell::new() };
    }

    /// Who handled faults before.
    static BEFORE: OnceLock<libc::sigaction> = OnceLock::new();

    /// How far from the stack pointer a guard page is met: by a call, or by a frame whose pages are touched one after
    /// the other.
    const NEAR: usize = 8 * PAGE;
    /// Stack for the handler.
    const ALTERNATE_BYTES: usize = 64 << 10;

    /// Where this thread goes on from now on when a stack overflows; returns what held before.
    pub fn change_refuge(refuge: Option<Refuge>) -> Option<Refuge> {
        if refuge.is_some() {
            BEFORE.get_or_init(install);
            ALTERNATE.with(|alternate| {
                alternate.get_or_init(Alternate::new);
            });
        }
        REFUGE.replace(refuge)
    }

    /// Touches the stack ahead as far as an allocator may need it: what ends there ends now, before the allocator has
    /// begun to change anything.
    #[inline(always)]
    pub fn touch_ahead() {
        let mark = 0_u8;
        let here = ptr::from_ref(&mark);
        for page in 1..=3 {
            // SAFETY: a volatile read of bytes that no Rust object lies in. Page by page they belong to the stack, or
            // to the guard page at its end, where the read is what the handler waits for.
            #[allow(unsafe_code)]
            unsafe {
                here.wrapping_sub(page * PAGE).read_volatile();
            }
        }
    }

    /// A stack for signals, of threads that have none yet.
    struct Alternate(*mut u8);

    impl Alternate {
        fn new() -> Self {
            // SAFETY: both are plain data of the system, which accepts zeros; the call only reads and writes them.
            #[allow(unsafe_code)]
            unsafe {
                let mut before: libc::stack_t = std::mem::zeroed();
                let asked = libc::sigaltstack(ptr::null(), &mut before);
                if asked != 0 || before.ss_flags & libc::SS_DISABLE == 0 {
                    return Alternate(ptr::null_mut());
                }
                let block = memory::map(ALTERNATE_BYTES);
                if !block.is_null() {
                    let own = libc::stack_t {
                        ss_sp: block.cast(),
                        ss_flags: 0,
                        ss_size: ALTERNATE_BYTES,
                    };
                    libc::sigaltstack(&own, ptr::null_mut());
                }
                Alternate(block)
            }
        }
    }

    impl Drop for Alternate {
        fn drop(&mut self) {
            if self.0.is_null() {
                return;
            }
            // SAFETY: the thread is at its end, no handler runs, and the block is of `map` with that many bytes.
            #[allow(unsafe_code)]
            unsafe {
                let none = libc::stack_t {
                    ss_sp: ptr::null_mut(),
                    ss_flags: libc::SS_DISABLE,
                    ss_size: 0,
                };
                libc::sigaltstack(&none, ptr::null_mut());
                memory::unmap(self.0, ALTERNATE_BYTES);
            }
        }
    }

    fn install() -> libc::sigaction {
        // SAFETY: the handler does what a handler may: it reads a cell of its thread that needs no set-up, and writes
        // registers.
        #[allow(unsafe_code)]
        unsafe {
            let mut own: libc::sigaction = std::mem::zeroed();
            let mut before: libc::sigaction = std::mem::zeroed();
            own.sa_sigaction = met_fault as *const () as usize;
            own.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigemptyset(&mut own.sa_mask);
            libc::sigaction(libc::SIGSEGV, &own, &mut before);
            before
        }
    }

    /// A fault of memory. Runs on the stack for signals.
    #[allow(unsafe_code)]
    unsafe extern "C" fn met_fault(
        signal: c_int,
        info: *mut libc::siginfo_t,
        context: *mut c_void,
    ) {
        // SAFETY: the system hands both out, for this call.
        let (address, is_guarded, registers) = unsafe {
            (
                (*info).si_addr() as usize,
                // Pages that are there and may not be touched, which guard pages are.
                (*info).si_code == SEGV_ACCERR,
                &mut (*context.cast::<libc::ucontext_t>()).uc_mcontext,
            )
        };
        let is_overflow = is_guarded && address.abs_diff(stack_pointer(registers)) <= NEAR;
        if is_overflow && let Ok(Some(refuge)) = REFUGE.try_with(Cell::take) {
            return go_on(registers, refuge);
        }
        // SAFETY: as its owner asked the system to call it.
        unsafe { hand_on(signal, info, context) };
    }

    const SEGV_ACCERR: c_int = 2;

    /// Calls who handled faults before, or lets the process end by this one.
    #[allow(unsafe_code)]
    unsafe fn hand_on(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
        let before = BEFORE.get();
        let handler = before.map_or(libc::SIG_DFL, |before| before.sa_sigaction);
        if handler == libc::SIG_DFL || handler == libc::SIG_IGN {
            // SAFETY: the default of the system; the instruction is tried again and ends the process.
            unsafe {
                let mut default: libc::sigaction = std::mem::zeroed();
                default.sa_sigaction = libc::SIG_DFL;
                libc::sigaction(signal, &default, ptr::null_mut());
            }
            return;
        }
        let takes_three = before.is_some_and(|before| before.sa_flags & libc::SA_SIGINFO != 0);
        // SAFETY: it was set as a handler of this kind.
        unsafe {
            if takes_three {
                let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) =
                    std::mem::transmute(handler);
                handler(signal, info, context);
            } else {
                let handler: extern "C" fn(c_int) = std::mem::transmute(handler);
                handler(signal);
            }
        }
    }

    #[cfg(target_arch = "x86_64")]
    fn stack_pointer(registers: &libc::mcontext_t) -> usize {
        registers.gregs[libc::REG_RSP as usize] as usize
    }

    /// The thread goes on in its refuge when the handler returns, as if that had been called from nowhere.
    #[cfg(target_arch = "x86_64")]
    fn go_on(registers: &mut libc::mcontext_t, refuge: Refuge) {
        /// Strings are walked backwards.
        const DIRECTION: i64 = 1 << 10;
        let gregs = &mut registers.gregs;
        // Where a call has just put its return address.
        gregs[libc::REG_RSP as usize] = ((refuge.stack & !15) - 8) as i64;
        gregs[libc::REG_RBP as usize] = 0;
        gregs[libc::REG_RIP as usize] = refuge.run as usize as i64;
        gregs[libc::REG_EFL as usize] &= !DIRECTION;
    }

    #[cfg(target_arch = "aarch64")]
    fn stack_pointer(registers: &libc::mcontext_t) -> usize {
        registers.sp as usize
    }

    /// The thread goes on in its refuge when the handler returns, as if that had been called from nowhere.
    #[cfg(target_arch = "aarch64")]
    fn go_on(registers: &mut libc::mcontext_t, refuge: Refuge) {
        registers.sp = (refuge.stack & !15) as u64;
        registers.regs[29] = 0;
        registers.regs[30] = 0;
        registers.pc = refuge.run as usize as u64;
    }
}

#[cfg(not(all(
    target_os = "linux",
    any(target_arch = "x86_64", target_arch = "aarch64")
)))]
mod imp {
    use super::Refuge;

    /// Here a stack that overflows ends the process.
    pub fn change_refuge(_: Option<Refuge>) -> Option<Refuge> {
        None
    }

    /// Nothing has to be ready.
    #[inline(always)]
    pub fn touch_ahead() {}
}
