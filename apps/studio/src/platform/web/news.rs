//! What happens beside the page, until the page looks at it.

use js_sys::{Array, Uint8Array};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// Wakes the page.
pub type Wake = Rc<dyn Fn()>;

/// A file in the browser's memory.
#[derive(Debug, Clone)]
pub struct JsFile {
    /// Its name.
    pub name: String,
    /// Its content.
    pub bytes: Uint8Array,
}

/// What happened beside the page.
pub enum News {
    /// The helper of this number said something.
    Said(u64, Array),
    /// The helper of this number ended with an error.
    Ended(u64, String),
    /// Files were chosen or dropped.
    Files(Vec<JsFile>),
    /// Something went wrong with them.
    Problem(String),
    /// The address was changed by hand.
    Address,
}

/// What happened and was not looked at yet.
pub type Inbox = Rc<RefCell<VecDeque<News>>>;
