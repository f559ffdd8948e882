//! Addresses of files beside a page.

use std::path::{Component, Path, PathBuf};

/// Address of `file` on a page that lies at `page`, both relative to the present folder or absolute.
pub(super) fn href(page: &Path, file: &Path) -> String {
    let parts: Vec<String> =
        way(page, file).components().map(|part| encoded(&part.as_os_str().to_string_lossy())).collect();
    if parts.is_empty() { ".".into() } else { parts.join("/") }
}

/// The same way in words: nothing is encoded.
pub(super) fn relative(page: &Path, file: &Path) -> String {
    let way = way(page, file);
    if way.as_os_str().is_empty() { ".".into() } else { way.display().to_string() }
}

fn way(page: &Path, file: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (page, file) = (absolute(page), absolute(file));
    let from: Vec<Component<'_>> = page.parent().map(|p| p.components().collect()).unwrap_or_default();
    let to: Vec<Component<'_>> = file.components().collect();
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    let up = std::iter::repeat_n(Component::ParentDir, from.len() - shared);
    up.chain(to[shared..].iter().copied()).collect()
}

/// A file name in an address.
fn encoded(name: &str) -> String {
    let byte = |b: u8| match b {
        b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => char::from(b).to_string(),
        other => format!("%{other:02X}"),
    };
    name.bytes().map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_relative_to_the_page() {
        for (page, file, address) in [
            ("results/a/report.html", "results/a/map.csv", "map.csv"),
            ("comparison.html", "results/a b/map.csv", "results/a%20b/map.csv"),
            ("/tmp/x/page.html", "/tmp/y/map.csv", "../y/map.csv"),
        ] {
            assert_eq!(href(Path::new(page), Path::new(file)), address);
        }
        assert_eq!(relative(Path::new("/x/page.html"), Path::new("/x/a b")), "a b");
        assert_eq!(relative(Path::new("/x/page.html"), Path::new("/x")), ".");
    }
}
