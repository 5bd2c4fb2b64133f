//! Memory of an image: lent on the chip, its own on a host.

/// Number of 32-bit words of the memory that an image needs: 64 KB.
pub const WORDS: usize = 16 * 1024;

/// Memory of an image on the chip: the second memory, once it has been found and lent.
#[cfg(target_os = "none")]
#[derive(Debug)]
pub struct ImageMemory(Option<&'static mut [u32; WORDS]>);

/// Memory of an image on a host.
#[cfg(not(target_os = "none"))]
#[derive(Clone, Debug)]
pub struct ImageMemory([u32; WORDS]);

impl Default for ImageMemory {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(target_os = "none")]
impl ImageMemory {
    /// Returns no memory. All bits are zero.
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
