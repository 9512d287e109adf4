#pragma once
// All capabilities that an engine may declare (rigid/README.md), and words that are none of them.
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::link {

/// The words of the protocol, in the order of rigid/README.md.
const std::vector<std::string>& capability_words();

/// A word that an engine declares and that is no capability, with the right words near it.
struct UnknownWord {
  std::string word;
  std::vector<std::string> near;  // the nearest first
};
std::vector<UnknownWord> unknown_words(const EngineInfo& info);

/// One sentence for each unknown word of the engine: the word, and what it may stand for.
std::vector<std::string> unknown_word_notes(const EngineInfo& info);

}  // namespace sunder::link
