#include "coupler/link/capabilities.h"

#include <algorithm>

#include <fmt/format.h>

#include "coupler/core/nearest.h"

namespace sunder::link {

const std::vector<std::string>& capability_words() {
  using namespace capability;
  static const std::vector<std::string> words{kSpheres,    kBoxes,      kHalfSpaces,  kConvexHulls,   kCompound,
                                              kContact,    kFriction,   kRestitution, kJoints,        kReleaseJoints,
                                              kMassRatios, kExportRows, kSaveRestore, kDeterministic, kDoublePrecision};
  return words;
}

std::vector<UnknownWord> unknown_words(const EngineInfo& info) {
  const std::vector<std::string>& known = capability_words();
  std::vector<UnknownWord> out;
  for (const std::string& word : info.capabilities)
    if (std::find(known.begin(), known.end(), word) == known.end()) out.push_back({word, nearest_names(word, known)});
  return out;
}

std::vector<std::string> unknown_word_notes(const EngineInfo& info) {
  std::vector<std::string> out;
  for (const UnknownWord& u : unknown_words(info))
    out.push_back(fmt::format("the engine '{}' declares '{}', which is no capability and counts for nothing: {}",
                              info.name, u.word, did_you_mean(u.word, capability_words())));
  return out;
}

}  // namespace sunder::link
