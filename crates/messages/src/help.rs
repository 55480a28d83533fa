//! Help texts of the command line.

/// Options or commands whose help is declared in both languages: the English one as the comment of the field or
/// variant, which is where clap takes it from, the Chinese one below it.
///
/// ```
/// use messages::LocalizedHelp;
///
/// #[derive(LocalizedHelp)]
/// struct Options {
///     /// Longest simulated time, s
///     #[zh("最长仿真时间，s")]
///     timeout: f64,
/// }
///
/// assert_eq!(Options::CHINESE, [("Longest simulated time, s", "最长仿真时间，s")]);
/// ```
pub trait LocalizedHelp {
    /// The help texts as clap shows them, English and Chinese.
    const CHINESE: &'static [(&'static str, &'static str)];
}
