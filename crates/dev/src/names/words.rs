//! The words that a type name or a comment is judged by.
//!
//! Lists instead of a dictionary: they are short, a reader can check them, and the figures stay comparable from one day
//! to the next.

/// Irregular past participles. Regular ones end in `ed` and are told from nouns by [`NOUNS_IN_ED`].
const PARTICIPLES: &[&str] = &[
    "Begun",
    "Bent",
    "Born",
    "Bound",
    "Broken",
    "Brought",
    "Built",
    "Caught",
    "Chosen",
    "Cut",
    "Done",
    "Drawn",
    "Driven",
    "Felt",
    "Forgotten",
    "Found",
    "Given",
    "Gone",
    "Grown",
    "Heard",
    "Held",
    "Hidden",
    "Kept",
    "Known",
    "Laid",
    "Led",
    "Left",
    "Lost",
    "Made",
    "Meant",
    "Met",
    "Paid",
    "Proven",
    "Put",
    "Read",
    "Seen",
    "Sent",
    "Shown",
    "Shut",
    "Sought",
    "Spent",
    "Split",
    "Spoken",
    "Stuck",
    "Taken",
    "Thought",
    "Thrown",
    "Told",
    "Torn",
    "Unwritten",
    "Woken",
    "Won",
    "Worn",
    "Written",
];

/// Present participles that describe a state. Other words in `ing` are nouns of the field: binding, encoding, framing.
const PRESENT_PARTICIPLES: &[&str] = &[
    "Being",
    "Bearing",
    "Becoming",
    "Beginning",
    "Braking",
    "Coming",
    "Doing",
    "Driving",
    "Ending",
    "Following",
    "Going",
    "Holding",
    "Incoming",
    "Jogging",
    "Lasting",
    "Leaving",
    "Living",
    "Making",
    "Meeting",
    "Missing",
    "Outgoing",
    "Passing",
    "Pending",
    "Playing",
    "Pressing",
    "Repeating",
    "Running",
    "Standing",
    "Stopping",
    "Storing",
    "Waiting",
];

/// Nouns and adjectives of the field that end in `ed` without being participles.
const NOUNS_IN_ED: &[&str] = &[
    "Speed", "Seed", "Feed", "Need", "Bed", "Embed", "Shed", "Thread", "Unified", "Id",
];

/// Pronouns, prepositions, conjunctions, adverbs, numerals and adjectives without a noun.
const FUNCTION_WORDS: &[&str] = &[
    "About",
    "Above",
    "Again",
    "Ahead",
    "All",
    "Alone",
    "Already",
    "Also",
    "Always",
    "Anew",
    "Any",
    "Apart",
    "Around",
    "As",
    "Aside",
    "At",
    "Away",
    "Back",
    "Backwards",
    "Before",
    "Behind",
    "Below",
    "Beneath",
    "Beside",
    "Between",
    "Beyond",
    "Both",
    "By",
    "Deep",
    "Deeper",
    "Down",
    "Each",
    "Earlier",
    "Either",
    "Else",
    "Enough",
    "Equal",
    "Ever",
    "Every",
    "Few",
    "First",
    "For",
    "Forth",
    "Forward",
    "Four",
    "Free",
    "From",
    "Further",
    "Here",
    "How",
    "If",
    "In",
    "Inner",
    "Into",
    "It",
    "Just",
    "Last",
    "Lately",
    "Later",
    "Least",
    "Less",
    "Like",
    "Live",
    "Many",
    "More",
    "Most",
    "Much",
    "Near",
    "Neither",
    "Never",
    "New",
    "Next",
    "No",
    "Nobody",
    "None",
    "Not",
    "Nothing",
    "Now",
    "Nowhere",
    "Of",
    "Off",
    "Old",
    "On",
    "Once",
    "One",
    "Only",
    "Onto",
    "Onward",
    "Or",
    "Other",
    "Out",
    "Outer",
    "Outermost",
    "Outside",
    "Outward",
    "Over",
    "Own",
    "Past",
    "Quick",
    "Quiet",
    "Same",
    "Silent",
    "Since",
    "Six",
    "So",
    "Solid",
    "Some",
    "Somebody",
    "Soon",
    "Still",
    "Such",
    "Than",
    "That",
    "Then",
    "There",
    "These",
    "They",
    "This",
    "Those",
    "Through",
    "To",
    "Together",
    "Too",
    "Top",
    "Towards",
    "Two",
    "Under",
    "Underneath",
    "Unlucky",
    "Until",
    "Unsure",
    "Up",
    "Upcoming",
    "Very",
    "What",
    "When",
    "Where",
    "Whether",
    "Which",
    "While",
    "Who",
    "Whole",
    "Whom",
    "Whose",
    "Why",
    "Wide",
    "With",
    "Within",
    "Without",
    "Wrong",
    "Yet",
];

/// Function words that read as riddles at the head of a longer name (`NotSet`, `OnlyPlayed`, `ToHandOver`).
const LEADING_FUNCTION_WORDS: &[&str] = &[
    "Any", "As", "At", "Before", "Being", "By", "From", "In", "Into", "Not", "Of", "On", "Only",
    "To", "Too", "Until", "With", "Without",
];

/// Names that a language's own keywords give to its syntax tree.
const KEYWORDS: &[&str] = &[
    "And",
    "For",
    "From",
    "If",
    "IfElse",
    "ImportFrom",
    "In",
    "Not",
    "Or",
    "While",
    "With",
    "WithItem",
    "YieldFrom",
];

/// Beginnings of comments that need the line before them to be understood.
const LEANING: &[&str] = &[
    "Also",
    "And",
    "As",
    "But",
    "It",
    "Its",
    "Likewise",
    "Or",
    "Otherwise",
    "Same",
    "See",
    "So",
    "Such",
    "Their",
    "Them",
    "Then",
    "They",
    "Which",
    "Why",
];

/// Two words that lean on another comment together.
const LEANING_PAIRS: &[&str] = &["The same", "The other", "The others", "The rest"];

/// Whether a type is named by a participle or a function word instead of a noun.
///
/// The last word decides, because in English it is the noun of the name; a function word at the beginning counts as
/// well.
#[must_use]
pub fn is_no_noun(name: &str) -> bool {
    if KEYWORDS.contains(&name) {
        return false;
    }
    let words = words(name);
    let Some((&last, before)) = words.split_last() else {
        return false;
    };
    let first = before.first().copied();
    is_participle(last)
        || FUNCTION_WORDS.contains(&last)
        || first.is_some_and(|word| LEADING_FUNCTION_WORDS.contains(&word))
}

/// Whether a comment begins with words that refer to another line.
#[must_use]
pub fn leans(comment: &str) -> bool {
    let mut words = comment.split(|c: char| !c.is_alphanumeric() && c != '\'');
    let first = words.next().unwrap_or_default();
    let second = words.next().unwrap_or_default();
    LEANING.contains(&first) || LEANING_PAIRS.contains(&format!("{first} {second}").as_str())
}

fn is_participle(word: &str) -> bool {
    PARTICIPLES.contains(&word)
        || PRESENT_PARTICIPLES.contains(&word)
        || (word.len() > 3 && word.ends_with("ed") && !NOUNS_IN_ED.contains(&word))
}

/// The words of a name in camel case; a run of capitals and digits belongs to the word that it begins.
fn words(name: &str) -> Vec<&str> {
    let bytes = name.as_bytes();
    let mut starts = vec![0];
    for at in 1..bytes.len() {
        if bytes[at].is_ascii_uppercase() && !bytes[at - 1].is_ascii_uppercase() {
            starts.push(at);
        }
    }
    starts.push(name.len());
    starts
        .windows(2)
        .map(|pair| &name[pair[0]..pair[1]])
        .collect()
}
