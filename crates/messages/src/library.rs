//! What libraries say of wrong input, in Chinese. Their sentences carry no identifier, so these alone are known by
//! their form; every text of our own is declared in both languages.

use crate::Text;

/// Sentences of a library: English forms in which `{}` stands for what varies, and Chinese ones in which `{0}` is the
/// first of these as it is, `{0~}` the same in Chinese. The first form that fits counts.
#[derive(Clone, Copy, Debug)]
pub struct LibrarySentences(pub &'static [(&'static str, &'static str)]);

/// Sentences and words of serde, serde_json, toml, base64 and the standard library.
const LIBRARY_SENTENCES: LibrarySentences = LibrarySentences(&[
    ("{} at line {} column {}", "{0~}（第 {1} 行第 {2} 列）"),
    (
        "failed to lookup address information: Temporary failure in name resolution",
        "暂时无法解析主机名",
    ),
    (
        "failed to lookup address information: Name or service not known",
        "找不到该主机名",
    ),
    (
        "string values must be quoted, expected literal string",
        "字符串值要加引号",
    ),
    (
        "unexpected key or value, expected newline, `{}`",
        "多余的键或值，应为换行或 `{0}`",
    ),
    ("cannot parse integer from empty string", "空文本不是整数"),
    (
        "lone leading surrogate in hex escape",
        "转义序列中缺少代理对的后一半",
    ),
    ("number too large to fit in target type", "数过大"),
    ("number too small to fit in target type", "数过小"),
    ("number would be zero for non-zero type", "不能为 0"),
    (
        "invalid literal string, expected `{}`",
        "字符串没有结束，应为 `{0}`",
    ),
    (
        "unknown field `{}`, there are no fields",
        "未知的键 `{0}`，这里没有键",
    ),
    ("stream did not contain valid UTF-8", "内容不是 UTF-8"),
    (
        "unclosed inline table, expected `{}`",
        "内联表没有结束，应为 `{0}`",
    ),
    (
        "unknown variant `{}`, expected one of {}",
        "未知的值 `{0}`，应为以下之一：{1}",
    ),
    (
        "invalid basic string, expected `{}`",
        "字符串没有结束，应为 `{0}`",
    ),
    (
        "invalid unquoted key, expected {}",
        "不带引号的键无效，应为{0~}",
    ),
    ("invalid digit found in string", "其中有不是数字的字符"),
    ("missing value, expected array", "缺少值"),
    (
        "unknown field `{}`, expected one of {}",
        "未知的键 `{0}`，应为以下之一：{1}",
    ),
    ("unexpected end of hex escape", "转义序列没有结束"),
    (
        "unknown variant `{}`, expected `{}` or `{}`",
        "未知的值 `{0}`，应为 `{1}` 或 `{2}`",
    ),
    ("EOF while parsing an object", "对象没有结束"),
    (
        "Invalid last symbol {}, offset {}.",
        "最后的字符（代码 {0}，位置 {1}）无效",
    ),
    ("invalid unicode code point", "Unicode 码位无效"),
    ("EOF while parsing a string", "字符串没有结束"),
    ("invalid IP address syntax", "不是 IP 地址"),
    ("key with no value, expected `{}`", "键没有值，应为 `{0}`"),
    ("recursion limit exceeded", "嵌套过深"),
    (
        "unknown field `{}`, expected `{}` or `{}`",
        "未知的键 `{0}`，应为 `{1}` 或 `{2}`",
    ),
    (
        "unknown variant `{}`, expected `{}`",
        "未知的值 `{0}`，应为 `{1}`",
    ),
    ("EOF while parsing a value", "缺少值，文本已结束"),
    ("invalid length {}, expected {}", "长度 {0} 无效，应为{1~}"),
    ("unclosed array, expected `{}`", "数组没有结束，应为 `{0}`"),
    ("unclosed table, expected `{}`", "表头没有结束，应为 `{0}`"),
    ("EOF while parsing a list", "数组没有结束"),
    ("extra `{}`, expected nothing", "多余的 `{0}`"),
    ("invalid value: {}, expected {}", "值无效：{0~}，应为{1~}"),
    ("unexpected key or value", "多余的键或值"),
    (
        "unknown field `{}`, expected `{}`",
        "未知的键 `{0}`，应为 `{1}`",
    ),
    (
        "Invalid symbol {}, offset {}.",
        "位置 {1} 的字符（代码 {0}）无效",
    ),
    ("invalid type: {}, expected {}", "类型无效：{0~}，应为{1~}"),
    ("Invalid input length: {}", "长度 {0} 无效"),
    ("trailing characters", "末尾之后还有内容"),
    ("key must be a string", "键必须是字符串"),
    ("number out of range", "数超出范围"),
    ("an array of length {}", "长度为 {0} 的数组"),
    ("Invalid padding", "末尾的填充无效"),
    ("duplicate field `{}`", "键 `{0}` 重复"),
    ("expected ident", "应为 true、false 或 null"),
    ("expected value", "应为一个值"),
    ("invalid escape", "转义序列无效"),
    ("invalid number", "数无效"),
    ("trailing comma", "末尾多余逗号"),
    ("floating point `{}`", "浮点数 `{0}`"),
    ("duplicate key", "键重复"),
    ("missing field `{}`", "缺少键 `{0}`"),
    ("expected `{}` or `{}`", "应为 `{0}` 或 `{1}`"),
    ("invalid key", "键无效"),
    ("a sequence", "数组"),
    ("expected `{}`", "应为 `{0}`"),
    ("expected {}", "应为{0~}"),
    ("a boolean", "布尔值"),
    ("an object", "对象"),
    ("sequence", "数组"),
    ("a string", "字符串"),
    ("boolean `{}`", "布尔值 `{0}`"),
    ("integer `{}`", "整数 `{0}`"),
    ("string \"{}\"", "字符串 \"{0}\""),
    ("string {}", "字符串 {0}"),
    ("usize", "非负整数"),
    ("a map", "表"),
    ("bool", "布尔值"),
    ("map", "表"),
    ("f32", "数"),
    ("f64", "数"),
    ("i64", "整数"),
    ("u16", "非负整数"),
    ("u32", "非负整数"),
    ("u64", "非负整数"),
    ("u8", "非负整数"),
]);

impl LibrarySentences {
    /// The Chinese form of a sentence that is known.
    pub fn chinese(self, english: &str) -> Option<String> {
        self.0.iter().find_map(|(form, chinese)| {
            let parts = parts_of(form, english)?;
            let numbered = parts.iter().enumerate();
            Some(
                numbered.fold((*chinese).to_owned(), |text, (number, part)| {
                    // A form of nothing but places would find itself again.
                    let is_word = part.len() < english.len();
                    let word = self.chinese(part).filter(|_| is_word);
                    text.replace(&format!("{{{number}~}}"), word.as_deref().unwrap_or(part))
                        .replace(&format!("{{{number}}}"), part)
                }),
            )
        })
    }
}

impl Text {
    /// What a library says; in Chinese as far as its sentences are known, otherwise in its own words.
    pub fn of_library(error: &impl std::fmt::Display) -> Self {
        let english = error.to_string();
        let chinese = LIBRARY_SENTENCES.chinese(&english);
        Self::recorded(english, chinese)
    }
}

/// What stands for each `{}` of a form; none if the text has another form.
fn parts_of<'t>(form: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let mut words = form.split("{}");
    let mut rest = text.strip_prefix(words.next()?)?;
    let mut words = words.peekable();
    let mut parts = Vec::new();
    while let Some(word) = words.next() {
        let at = match words.peek() {
            // The last words are the end of the text.
            None => rest.strip_suffix(word)?.len(),
            Some(_) => rest.find(word)?,
        };
        parts.push(&rest[..at]);
        rest = &rest[at + word.len()..];
    }
    rest.is_empty().then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_of_libraries_are_known_by_their_form() {
        let known = |english| LIBRARY_SENTENCES.chinese(english);
        assert_eq!(known("missing field `to`").as_deref(), Some("缺少键 `to`"));
        assert_eq!(
            known("invalid type: integer `1`, expected a string").as_deref(),
            Some("类型无效：整数 `1`，应为字符串")
        );
        assert_eq!(
            known("trailing comma at line 1 column 4").as_deref(),
            Some("末尾多余逗号（第 1 行第 4 列）")
        );
        assert_eq!(known("a sentence that no library says"), None);
        assert_eq!(known(""), None);
        let text = Text::of_library(&"words of nobody");
        assert_eq!(text.other_chinese(), None);
    }
}
