//! Memory of an image: lent on the chip, its own on a host.

/// Number of 32-bit words of the memory that an image needs: 64 KB.
pub const WORDS: usize = 16 * 1024;

/// The words: on the chip those of the second memory, once it has been found and lent; all bits are zero before.
#[cfg(target_os = "none")]
type ImageWords = Option<&'static mut [u32; WORDS]>;
#[cfg(not(target_os = "none"))]
type ImageWords = [u32; WORDS];

/// Memory of an image.
#[derive(Debug)]
#[cfg_attr(not(target_os = "none"), derive(Clone))]
pub struct ImageMemory(ImageWords);

impl Default for ImageMemory {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(target_os = "none")]
impl ImageMemory {
    /// Returns no memory.
    pub const fn new() -> Self {
        Self(None)
    }

    /// Takes the memory in which images are made from now on.
    pub fn lend(&mut self, words: &'static mut [u32; WORDS]) {
        self.0 = Some(words);
    }

    /// Returns the words; none without memory.
    pub fn words(&self) -> &[u32] {
        self.0.as_ref().map_or(&[], |words| words.as_slice())
    }

    /// Returns the words; none without memory.
    pub fn words_mut(&mut self) -> &mut [u32] {
        self.0
            .as_mut()
            .map_or(&mut [], |words| words.as_mut_slice())
    }
}

#[cfg(not(target_os = "none"))]
impl ImageMemory {
    /// Returns a memory of its own.
    pub const fn new() -> Self {
        Self([0; WORDS])
    }

    /// Returns the words.
    pub fn words(&self) -> &[u32] {
        &self.0
    }

    /// Returns the words.
    pub fn words_mut(&mut self) -> &mut [u32] {
        &mut self.0
    }
}
