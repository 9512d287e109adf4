#include "coupler/core/nearest.h"

#include <algorithm>
#include <cctype>
#include <span>
#include <utility>

#include <fmt/format.h>

namespace sunder {
namespace {

constexpr std::size_t kMostNames = 3;    // that a message proposes
constexpr std::size_t kMostListed = 20;  // that a message lists where none is near
constexpr int kLettersPerError = 3;      // more errors than one in three letters make another word

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

}  // namespace

int edit_distance(const std::string& a, const std::string& b) {
  const std::size_t columns = b.size() + 1;
  std::vector<int> before(columns), above(columns), row(columns);  // rows i - 2, i - 1 and i of the table
  for (std::size_t j = 0; j < columns; ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before, above), std::swap(above, row);
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j < columns; ++j) {
      const int differs = lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1;
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + differs});
      if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

std::vector<std::string> nearest_names(const std::string& typed, const std::vector<std::string>& names) {
  std::vector<std::pair<int, std::string>> near;
  for (const std::string& name : names) {
    const bool words_missing = !typed.empty() && name.starts_with(typed + "_");
    const int distance = words_missing ? 1 : edit_distance(typed, name);
    const int letters = static_cast<int>(std::max(typed.size(), name.size()));
    if (words_missing || kLettersPerError * distance <= letters) near.emplace_back(distance, name);
  }
  std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> out;
  for (const auto& [distance, name] : near)
    if (out.size() < kMostNames && distance <= 2 * near.front().first) out.push_back(name);
  return out;
}

std::string did_you_mean(const std::string& typed, const std::vector<std::string>& names) {
  const std::vector<std::string> near = nearest_names(typed, names);
  if (!near.empty()) {
    std::string text;
    for (std::size_t i = 0; i < near.size(); ++i)
      text += fmt::format("{}'{}'", i == 0 ? "" : i + 1 == near.size() ? " or " : ", ", near[i]);
    return "did you mean " + text + "?";
  }
  if (names.empty()) return "there is none";
  const std::span<const std::string> first(names.data(), std::min(names.size(), kMostListed));
  return fmt::format("there are: {}{}", fmt::join(first, ", "),
                     names.size() > first.size() ? fmt::format(" and {} more", names.size() - first.size()) : "");
}

}  // namespace sunder
