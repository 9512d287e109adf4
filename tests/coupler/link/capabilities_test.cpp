// Words that an engine declares and that are no capabilities.
#include "coupler/link/capabilities.h"

#include <gtest/gtest.h>

using namespace sunder::link;

TEST(Capabilities, AllWordsAreKnown) {
  EXPECT_EQ(capability_words().size(), 15u);
  EXPECT_TRUE(unknown_words({"toy", "1", capability_words()}).empty());
}

TEST(Capabilities, AnUnknownWordIsToldWithTheNearest) {
  const EngineInfo toy{"toy", "1", {"spheres", "conact", "export_row", "wings"}};
  const auto notes = unknown_word_notes(toy);
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_EQ(
      notes[0],
      "the engine 'toy' declares 'conact', which is no capability and counts for nothing: did you mean 'contact'?");
  EXPECT_NE(notes[1].find("did you mean 'export_rows'?"), std::string::npos) << notes[1];
  EXPECT_NE(notes[2].find("'wings', which is no capability and counts for nothing: there are: spheres, boxes,"),
            std::string::npos)
      << notes[2];
}
