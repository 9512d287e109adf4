#pragma once
// Rebounds within a window: when two bodies touch, and how they go on for the rest of it. An engine that solves a
// rebound at the window's end would leave both at their touch, and lose what is left of the window.
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace sunder::rigid {

/// A contact of a window.
struct Strike {
  std::uint32_t first = 0, second = 0;  // the bodies
  double gap = 0.0;                     // at the start [m]
  double approach = 0.0;                // closing speed, of the average velocities [m/s]
  double pull = 0.0;                    // opening acceleration, without the contact [m/s^2]
  double restitution = 0.0;             // [-]; 0 where it does not bounce
  bool acted = false;                   // the first solve gave it an impulse
};

/// What becomes of two bodies that bounce.
struct Rebound {
  double touch = 0.0;  // since the window's start [s]
  double speed = 0.0;  // opening speed at the window's end [m/s]
};

/// Returns the rebound of a strike in a window of `window_s`; none where it is unsound: the bodies do not meet, gravity
/// brings them together again within the window, or it changes their speed by more than a fifth. With the acceleration
/// p, closing speed c0 = c + p H / 2 at the start, they touch at c_t^2 = c0^2 - 2 p gap after t = 2 gap / (c0 + c_t).
/// For the rest r = H - t they fly with e c_t + p r / 2.
std::optional<Rebound> rebound(const Strike& strike, double window_s);

/// Returns the rebounds of a window's strikes, by strike. A body takes part with one partner only, which is static or
/// has none but this body. All contacts of such a pair that acted bounce, at one time but for a twentieth of the
/// window. Their touch is then the latest one. Contacts that did not act are left to the sweep of the way back
/// (way_back.h). `joined`: a joint holds the body, or the shell process solves contacts of it.
std::vector<std::optional<Rebound>> rebounds(const std::vector<Strike>& strikes, double window_s,
                                             const std::function<bool(std::uint32_t)>& is_static,
                                             const std::function<bool(std::uint32_t)>& joined);

}  // namespace sunder::rigid
