#pragma once

namespace bayesctrl::testing {

/// Whether memory is watched by a sanitizer, which keeps what was freed, and more of what is not.
#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace bayesctrl::testing
