//! Whether this CPU can run this build, found out before anything compiled for x86-64-v3 runs.
//!
//! `is_x86_feature_detected!` cannot answer: what the build was compiled for, it takes for granted. So this is
//! raw CPUID and XGETBV, in assembly of baseline instructions (even `main` may hold AVX or BMI instructions).
//! On Linux it runs from `.init_array`, before `main`, and writes and exits by system calls. On other systems
//! `main` calls it first, which is early enough as long as the compiler puts no vector instruction before it.
//!
//! A build for plain x86-64, or for another architecture, needs nothing that could be missing.
//!
//! References: Intel SDM volume 2A, CPUID; volume 1, section 14.3 (detection of AVX by OSXSAVE and XCR0).
#![allow(
    unsafe_code,
    reason = "assembly is the only code that runs on every x86-64 CPU whatever the build's flags"
)]

/// The exit code of a build on a CPU that cannot run it.
pub const EXIT_CODE: u8 = 4;

/// What is said then.
pub const MESSAGE: &str = if cfg!(target_feature = "avx512f") {
    "error: this build needs a CPU with AVX-512 (or others of the building machine's instructions), \
     which this one lacks; build octray here with RUSTFLAGS=\"-C target-cpu=native\"\n"
} else if cfg!(target_feature = "avx2") {
    "error: this build needs a CPU with AVX2, FMA and BMI2 (x86-64-v3), which this one lacks; \
     build octray here with RUSTFLAGS=\"-C target-cpu=native\"\n"
} else {
    "error: this build needs a CPU with instructions that this one lacks; \
     build octray here with RUSTFLAGS=\"-C target-cpu=native\"\n"
};

/// Whether this CPU or its operating system lacks instructions that this build uses.
#[must_use]
pub fn lacks_instructions() -> bool {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: `x86_64::lacks` takes nothing, keeps to the C calling convention and touches no memory.
    let lacks = unsafe { x86_64::lacks() } != 0;
    #[cfg(not(target_arch = "x86_64"))]
    let lacks = false;
    lacks
}

#[cfg(target_arch = "x86_64")]
mod x86_64 {
    /// `1 << bit` if the build was compiled for the target feature, else 0; or-ed over the list.
    macro_rules! needed {
        ($($feature:literal: $bit:literal),* $(,)?) => {
            0u32 $(| if cfg!(target_feature = $feature) { 1u32 << $bit } else { 0 })*
        };
    }

    /// CPUID leaf 1, ECX. AVX asks for OSXSAVE (bit 27) too, without which XGETBV is no instruction.
    const LEAF_1_ECX: u32 = needed! {
        "sse3": 0, "pclmulqdq": 1, "ssse3": 9, "fma": 12, "cmpxchg16b": 13, "sse4.1": 19, "sse4.2": 20,
        "movbe": 22, "popcnt": 23, "aes": 25, "avx": 27, "avx": 28, "f16c": 29,
    };
    /// CPUID leaf 7, subleaf 0, EBX.
    const LEAF_7_EBX: u32 = needed! {
        "bmi1": 3, "avx2": 5, "bmi2": 8, "avx512f": 16, "avx512dq": 17, "adx": 19, "avx512ifma": 21,
        "avx512cd": 28, "avx512bw": 30, "avx512vl": 31,
    };
    /// CPUID leaf 7, subleaf 0, ECX.
    const LEAF_7_ECX: u32 = needed! {
        "avx512vbmi": 1, "avx512vbmi2": 6, "gfni": 8, "vaes": 9, "vpclmulqdq": 10, "avx512vnni": 11,
        "avx512bitalg": 12, "avx512vpopcntdq": 14,
    };
    /// CPUID leaf 0x8000_0001, ECX.
    const LEAF_80000001_ECX: u32 = needed! { "lzcnt": 5 };
    /// XCR0: state that the operating system must save. XMM and YMM for AVX; opmasks and ZMM for AVX-512.
    const XCR0: u32 = needed! { "avx": 1, "avx": 2, "avx512f": 5, "avx512f": 6, "avx512f": 7 };

    /// 1 if something is missing, else 0.
    ///
    /// # Safety
    /// None needed; `unsafe` because it is assembly. Baseline x86-64 only; RBX, the one register here that
    /// callers expect unchanged (System V and Windows alike), is kept in R8; no stack is used.
    // SAFETY: the body ends in `ret` on every way and keeps the calling convention, as said above.
    #[unsafe(naked)]
    pub unsafe extern "C" fn lacks() -> u32 {
        core::arch::naked_asm!(
            "mov r8, rbx",
            // R9D: the highest basic leaf. Leaf 1 is always there.
            "xor eax, eax",
            "cpuid",
            "mov r9d, eax",
            "mov eax, 1",
            "xor ecx, ecx",
            "cpuid",
            "not ecx",
            "test ecx, {leaf_1_ecx}",
            "jnz 3f",
            // With AVX compiled in, the test above has made sure of OSXSAVE.
            "mov eax, {xcr0}",
            "test eax, eax",
            "jz 2f",
            "xor ecx, ecx",
            "xgetbv",
            "not eax",
            "test eax, {xcr0}",
            "jnz 3f",
            "2:",
            // Leaf 7: all zero where the CPU has no such leaf.
            "xor ebx, ebx",
            "xor ecx, ecx",
            "cmp r9d, 7",
            "jb 4f",
            "mov eax, 7",
            "cpuid",
            "4:",
            "not ebx",
            "test ebx, {leaf_7_ebx}",
            "jnz 3f",
            "not ecx",
            "test ecx, {leaf_7_ecx}",
            "jnz 3f",
            // Every 64-bit CPU has leaf 0x8000_0001: it says so there.
            "mov eax, 0x80000001",
            "cpuid",
            "not ecx",
            "test ecx, {leaf_80000001_ecx}",
            "jnz 3f",
            "mov rbx, r8",
            "xor eax, eax",
            "ret",
            "3:",
            "mov rbx, r8",
            "mov eax, 1",
            "ret",
            leaf_1_ecx = const LEAF_1_ECX,
            leaf_7_ebx = const LEAF_7_EBX,
            leaf_7_ecx = const LEAF_7_ECX,
            leaf_80000001_ecx = const LEAF_80000001_ECX,
            xcr0 = const XCR0,
        )
    }

    #[cfg(target_os = "linux")]
    mod early {
        use super::super::{EXIT_CODE, MESSAGE};

        /// The message's bytes, where assembly can name them.
        static TEXT: [u8; MESSAGE.len()] = {
            let mut text = [0; MESSAGE.len()];
            text.copy_from_slice(MESSAGE.as_bytes());
            text
        };

        /// The C runtime calls what is listed in `.init_array` before `main`, and 90 before the entries
        /// without a number.
        // SAFETY: the section holds pointers to functions of the C calling convention, and this is one. It
        // takes none of the arguments that the runtime passes, which that convention allows.
        #[used]
        #[unsafe(link_section = ".init_array.00090")]
        static CHECK: unsafe extern "C" fn() = check;

        /// Returns if nothing is missing; else writes the message to standard error and exits.
        ///
        /// # Safety
        /// None needed; `unsafe` because it is assembly.
        // SAFETY: the stack is moved by 8 to be aligned for the call, and back. The other way ends in
        // `exit_group`, which does not return; `write` reads `TEXT` alone, with its own length.
        #[unsafe(naked)]
        unsafe extern "C" fn check() {
            core::arch::naked_asm!(
                "sub rsp, 8",
                "call {lacks}",
                "add rsp, 8",
                "test eax, eax",
                "jnz 2f",
                "ret",
                "2:",
                // write(2, TEXT, length)
                "mov eax, 1",
                "mov edi, 2",
                "lea rsi, [rip + {text}]",
                "mov edx, {length}",
                "syscall",
                // exit_group(EXIT_CODE)
                "mov eax, 231",
                "mov edi, {exit_code}",
                "syscall",
                "ud2",
                lacks = sym super::lacks,
                text = sym TEXT,
                length = const MESSAGE.len(),
                exit_code = const EXIT_CODE,
            )
        }
    }
}
