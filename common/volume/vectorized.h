// Loops that are compiled for wider registers too.
#pragma once

// Before a function: it is compiled twice, and the program picks the version for 256-bit registers on processors that
// have them. Such functions compute in integers, so both give the same. Sanitizers cannot start before the choice is
// made, so they see the plain version.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define VOXCARVE_VECTORIZED __attribute__((target_clones("avx2", "default"), optimize("O3")))
#else
#define VOXCARVE_VECTORIZED
#endif
