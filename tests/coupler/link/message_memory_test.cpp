#include <gtest/gtest.h>

#include "coupler/link/message_memory.h"
#include "coupler/link/messages.h"
#include "tests/coupler/shard.h"

using namespace sunder;

TEST(MessageMemory, IsOneBlockThatGrowsAndIsReused) {
  constexpr std::size_t kMost = 1 << 18;
  link::MessageMemory memory(kMost, true);
  const auto fill = [&memory](int bodies) {
    auto& request = *google::protobuf::Arena::CreateMessage<proto::Request>(&memory.fresh());
    for (int k = 1; k <= bodies; ++k)
      link::encode(link::Motion{static_cast<BodyId>(k), shard().motion}, request.mutable_window()->add_predicted());
    EXPECT_EQ(request.window().predicted(bodies - 1).id(), static_cast<BodyId>(bodies));
    EXPECT_EQ(request.window().predicted(0).velocity().y(), 2.0);
    return &request;
  };
  fill(1), fill(300);
  const proto::Request* const grown = fill(300);
  EXPECT_EQ(fill(300), grown);
  EXPECT_EQ(fill(1), grown);
  // above its limit it takes more memory, frees it afterwards, and keeps its block
  fill(3000);
  const proto::Request* const largest = fill(3000);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(fill(3000), largest);
  EXPECT_EQ(fill(1), largest);
}
