// Whether the address sanitizer watches.
#pragma once

namespace voxcarve {

// GCC says so by a macro, Clang by a feature; other headers give GCC a __has_feature that knows none.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kAddressSanitizer = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr bool kAddressSanitizer = true;
#else
inline constexpr bool kAddressSanitizer = false;
#endif
#else
inline constexpr bool kAddressSanitizer = false;
#endif

}  // namespace voxcarve
