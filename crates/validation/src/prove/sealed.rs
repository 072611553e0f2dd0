//! The seal on the answers: it keeps people and programs from reading them by accident, and is no secret.

use sha2::{Digest, Sha256};

use super::error::ProveError;

const SCHEMA: &str = "stiffbench/sealed-answers/1";
const PHRASE: &[u8] = b"concealed benches of stiffbench";

/// The plain text of sealed answers; `data/concealed/README.md` describes the form.
///
/// # Errors
/// [`ProveError::Seal`] for another form, [`ProveError::Damaged`] if length or SHA-256 of the plain text are not as stated.
pub fn unseal(text: &str) -> Result<String, ProveError> {
    let wrong = |problem: &str| ProveError::Seal {
        problem: problem.to_owned(),
    };
    let (head, body) = text
        .split_once("\n\n")
        .ok_or_else(|| wrong("no empty line ends its header"))?;
    let fact = |name: &str| {
        head.lines()
            .filter_map(|line| line.split_once(" = "))
            .find(|(key, _)| *key == name)
            .map(|(_, value)| value)
            .ok_or_else(|| wrong(&format!("its header has no `{name}`")))
    };
    if fact("schema")? != SCHEMA {
        return Err(wrong(&format!("its schema is not {SCHEMA}")));
    }
    let hidden = bytes(body).ok_or_else(|| wrong("its body is not made of hexadecimal digits"))?;
    let plain: Vec<u8> = hidden
        .iter()
        .zip(keystream())
        .map(|(byte, key)| byte ^ key)
        .collect();
    let stated = (fact("plain_bytes")?, fact("plain_sha256")?);
    let found = (plain.len().to_string(), digest(&plain));
    if stated != (found.0.as_str(), found.1.as_str()) {
        return Err(ProveError::Damaged {
            stated_bytes: stated.0.to_owned(),
            found_bytes: plain.len(),
            stated_sha256: stated.1.to_owned(),
            found_sha256: found.1,
        });
    }
    String::from_utf8(plain).map_err(|_| wrong("its plain text is not UTF-8"))
}

/// SHA-256 in hexadecimal.
fn digest(bytes: &[u8]) -> String {
    use std::fmt::Write;
    let mut digits = String::new();
    for byte in Sha256::digest(bytes) {
        let _ = write!(digits, "{byte:02x}");
    }
    digits
}

/// SHA-256 of the phrase and a counter, block after block.
fn keystream() -> impl Iterator<Item = u8> {
    (0_u64..).flat_map(|counter| {
        Sha256::new()
            .chain_update(PHRASE)
            .chain_update(counter.to_be_bytes())
            .finalize()
    })
}

/// Bytes of hexadecimal digits, white space between them left out.
fn bytes(digits: &str) -> Option<Vec<u8>> {
    let digits: Vec<u8> = digits
        .chars()
        .filter(|c| !c.is_whitespace())
        .map(|c| c.to_digit(16).map(|digit| digit as u8))
        .collect::<Option<_>>()?;
    if digits.len() % 2 == 1 {
        return None;
    }
    Some(
        digits
            .chunks(2)
            .map(|pair| 16 * pair[0] + pair[1])
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seals, for tests only: the stored file was sealed by `data/concealed/generate/seal.py`.
    fn seal(plain: &[u8]) -> String {
        let hidden: Vec<String> = plain
            .iter()
            .zip(keystream())
            .map(|(byte, key)| format!("{:02x}", byte ^ key))
            .collect();
        format!(
            "schema = {SCHEMA}\nplain_bytes = {}\nplain_sha256 = {}\n\n{}\n",
            plain.len(),
            digest(plain),
            hidden.concat()
        )
    }

    #[test]
    fn what_was_sealed_opens() {
        // Longer than two blocks of the keystream.
        let plain = "answers, ".repeat(9);
        assert_eq!(unseal(&seal(plain.as_bytes())).unwrap(), plain);
        assert_eq!(unseal(&seal(b"")).unwrap(), "");
    }

    #[test]
    fn a_changed_digit_is_noticed() {
        let sealed = seal(b"nothing-missing");
        let last = sealed.trim_end().chars().next_back().unwrap();
        let other = if last == '0' { '1' } else { '0' };
        let changed = format!("{}{other}\n", &sealed[..sealed.len() - 2]);
        assert!(matches!(unseal(&changed), Err(ProveError::Damaged { .. })));
        let shorter = format!("{}\n", &sealed[..sealed.len() - 3]);
        assert!(matches!(unseal(&shorter), Err(ProveError::Damaged { .. })));
    }

    #[test]
    fn another_form_is_refused() {
        for text in [
            "{}",
            "schema = other\n\n00",
            "plain_bytes = 0\n\n00",
            &seal(b"a").replace("plain_sha256", "sha"),
            &format!("{}x0\n", seal(b"a").trim_end()),
            &format!("{}0\n", seal(b"a").trim_end()),
            &seal(&[0xff, 0xfe]),
        ] {
            let refused = unseal(text);
            assert!(matches!(refused, Err(ProveError::Seal { .. })), "{text}");
        }
    }
}
