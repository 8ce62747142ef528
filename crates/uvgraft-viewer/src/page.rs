//! Embeds an avatar in the page.

use std::io::{self, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use serde::Serialize;

use crate::{Glb, WebImage};

/// The page's markup, split where data is inserted.
#[derive(Debug, Clone, Copy)]
pub struct Template<'a> {
    before_title: &'a str,
    before_data: &'a str,
    rest: &'a str,
}

/// A page into which data cannot be inserted.
#[derive(Debug, thiserror::Error)]
#[error("the viewer page lacks the placeholder `{mark}`")]
pub struct TemplateError {
    /// The missing placeholder.
    pub mark: &'static str,
}

const TITLE: &str = "<!-- uvgraft:title -->";
const DATA: &str = "<!-- uvgraft:data -->";

impl<'a> Template<'a> {
    /// Splits a page, such as [`crate::PAGE`], at its placeholders.
    ///
    /// # Errors
    /// [`TemplateError`] if a placeholder, for the title or for the data, is missing.
    pub fn new(html: &'a str) -> Result<Self, TemplateError> {
        let (before_title, rest) = html.split_once(TITLE).ok_or(TemplateError { mark: TITLE })?;
        let (before_data, rest) = rest.split_once(DATA).ok_or(TemplateError { mark: DATA })?;
        Ok(Self { before_title, before_data, rest })
    }
}

/// An avatar and a choice of textures. Names are displayed and may be any text.
#[derive(Debug)]
pub struct Page<'a> {
    /// Name of the avatar, such as its file name.
    pub name: &'a str,
    /// The avatar.
    pub model: Glb<'a>,
    /// Further textures, each with a name.
    pub textures: Vec<(&'a str, WebImage<'a>)>,
    /// What the camera is aimed at first; the whole avatar if `None`.
    pub look_at: Option<LookAt<'a>>,
}

/// A target for the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(untagged)]
pub enum LookAt<'a> {
    /// A bone by its VRM name, or any node by its name.
    Named(&'a str),
    /// Two corners of a box, in metres.
    Box([f32; 6]),
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct About<'a> {
    name: &'a str,
    textures: Vec<TextureAbout<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    look_at: Option<LookAt<'a>>,
}

#[derive(Serialize)]
struct TextureAbout<'a> {
    name: &'a str,
    r#type: &'a str,
}

impl Page<'_> {
    /// Writes the page as UTF-8: names as JSON, files as base64, each in a script element that
    /// browsers do not execute.
    ///
    /// # Errors
    /// Those of writing to `out`.
    pub fn write(&self, template: &Template<'_>, out: &mut impl Write) -> io::Result<()> {
        out.write_all(template.before_title.as_bytes())?;
        write!(out, "<title>{}</title>", escaped(self.name))?;
        out.write_all(template.before_data.as_bytes())?;
        let textures = self.textures.iter();
        let about = About {
            name: self.name,
            textures: textures
                .map(|&(name, picture)| TextureAbout { name, r#type: picture.media_type() })
                .collect(),
            look_at: self.look_at,
        };
        // In JSON, `<` occurs only inside strings, where it may be escaped. Without it, nothing can
        // close the element.
        let json = serde_json::to_string(&about)?.replace('<', "\\u003c");
        writeln!(out, "<script type=\"application/json\" id=\"about-data\">{json}</script>")?;
        block("model-data", self.model.bytes(), out)?;
        for (index, (_, picture)) in self.textures.iter().enumerate() {
            block(&format!("texture-data-{index}"), picture.bytes(), out)?;
        }
        out.write_all(template.rest.as_bytes())
    }
}

fn block(id: &str, bytes: &[u8], out: &mut impl Write) -> io::Result<()> {
    write!(out, "<script type=\"text/base64\" id=\"{id}\">")?;
    let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
    encoder.write_all(bytes)?;
    encoder.finish()?;
    drop(encoder);
    writeln!(out, "</script>")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    const HTML: &str = "<head><!-- uvgraft:title --></head><!-- uvgraft:data --><p>end";
    const GLB: &[u8] = b"glTF\x02\0\0\0\x16\0\0\0\x02\0\0\0JSON{}";

    fn written(name: &str, texture: &str) -> String {
        let picture = WebImage::new(b"\xff\xd8\xff").unwrap();
        let textures = vec![(texture, picture)];
        let page = Page { name, model: Glb::new(GLB).unwrap(), textures, look_at: None };
        let mut out = Vec::new();
        page.write(&Template::new(HTML).unwrap(), &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn everything_is_in_its_place() {
        let wanted = concat!(
            "<head><title>me.glb</title></head>",
            r#"<script type="application/json" id="about-data">"#,
            r#"{"name":"me.glb","textures":[{"name":"a.jpg","type":"image/jpeg"}]}</script>"#,
            "\n<script type=\"text/base64\" id=\"model-data\">",
            "Z2xURgIAAAAWAAAAAgAAAEpTT057fQ==</script>\n",
            "<script type=\"text/base64\" id=\"texture-data-0\">/9j/</script>\n<p>end",
        );
        assert_eq!(written("me.glb", "a.jpg"), wanted);
    }

    #[test]
    fn camera_targets_are_names_or_boxes() {
        let reported = |look_at| serde_json::to_string(&look_at).unwrap();
        assert_eq!(reported(LookAt::Named("leftHand")), r#""leftHand""#);
        assert_eq!(
            reported(LookAt::Box([0.0, 1.0, 0.0, 1.0, 2.0, 0.5])),
            "[0.0,1.0,0.0,1.0,2.0,0.5]"
        );
    }

    #[test]
    fn names_cannot_leave_their_element() {
        let evil = "</title></script><!--<script>alert(1)</script>&amp;\u{2028}\"\\";
        let html = written(evil, evil);
        let plain = written("x", "x");
        for tag in ["<script", "</script", "<!--", "<title", "</title"] {
            assert_eq!(html.matches(tag).count(), plain.matches(tag).count(), "{tag} in {html}");
        }
        let json = html.split_once("about-data\">").unwrap().1.split_once("</script>").unwrap().0;
        let about: serde_json::Value = serde_json::from_str(json).unwrap();
        assert_eq!(about["name"], evil);
        assert_eq!(about["textures"][0]["name"], evil);
        assert!(html.contains("alert(1)&lt;/script>&amp;amp;"), "{html}");
    }

    #[test]
    fn placeholders_in_names_stay_text() {
        let html = written(DATA, TITLE);
        assert_eq!(html.matches("model-data").count(), 1);
        assert!(html.starts_with("<head><title>&lt;!-- uvgraft:data --></title>"), "{html}");
    }

    #[test]
    fn pages_without_placeholders_are_refused() {
        assert!(Template::new("<p>").unwrap_err().to_string().contains("uvgraft:title"));
        assert!(Template::new(TITLE).unwrap_err().to_string().contains("uvgraft:data"));
    }

    #[test]
    fn the_embedded_page_takes_data() {
        if let Some(page) = crate::PAGE {
            let template = Template::new(page).unwrap();
            assert!(template.before_title.contains("default-src 'none'"));
            assert!(template.rest.contains("uvgraft"));
        }
    }
}
