#pragma once
// The right names nearest to a mistyped one, for messages.
#include <string>
#include <vector>

namespace sunder {

/// Number of insertions, deletions, substitutions and swaps of neighbours that turn `a` into `b`, where a letter takes
/// part in one of them at most (optimal string alignment). Upper and lower case count as the same.
int edit_distance(const std::string& a, const std::string& b);

/// At most three of `names` that `typed` may stand for, the nearest first. A name is near where a third of its letters
/// or fewer differ, or where `typed` is its beginning and only words are missing ("angle" for "angle_deg"). Names more
/// than twice as far off as the nearest are left out. Names at one distance keep their order.
std::vector<std::string> nearest_names(const std::string& typed, const std::vector<std::string>& names);

/// "did you mean 'a' or 'b'?" with the nearest names. Where none is near: "there are: a, b, c", or "there is none".
std::string did_you_mean(const std::string& typed, const std::vector<std::string>& names);

}  // namespace sunder
