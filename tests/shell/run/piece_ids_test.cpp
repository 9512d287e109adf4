// Ids of pieces: who keeps one where a piece splits, leaves, or comes together again.
#include <gtest/gtest.h>

#include "shell/run/piece_ids.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

using Ids = std::vector<std::vector<BodyId>>;

// One shell of six points of equal mass.
PieceIds six() { return {{std::vector<double>(6, 1.0)}, 10}; }

}  // namespace

TEST(PieceIds, TheHeaviestPartOfASplitPieceKeepsTheId) {
  PieceIds ids = six();
  EXPECT_EQ(ids.of_points(), Ids({{0, 0, 0, 0, 0, 0}}));
  ids.look({{0, 0, 0, 0, 0, 0}});
  EXPECT_EQ(ids.of_points(), Ids({{10, 10, 10, 10, 10, 10}}));
  ids.look({{0, 0, 1, 1, 1, 1}});
  EXPECT_EQ(ids.of_points(), Ids({{11, 11, 10, 10, 10, 10}}));
  ids.look({{7, 7, 3, 3, 3, 5}});  // numbers of the caller mean nothing from one look to the next
  EXPECT_EQ(ids.of_points(), Ids({{11, 11, 10, 10, 10, 12}}));
  ids.look({{0, 1, 2, 2, 2, 3}});  // two parts alike: that of the lower point keeps it
  EXPECT_EQ(ids.of_points(), Ids({{11, 13, 10, 10, 10, 12}}));
  ids.look({{3, 2, 1, 1, 1, 0}});
  EXPECT_EQ(ids.of_points(), Ids({{11, 13, 10, 10, 10, 12}}));
}

TEST(PieceIds, MassAtRestDecidesAndNotTheNumberOfPoints) {
  PieceIds ids({{1.0, 1.0, 1.0}, {5.0}}, 1);
  ids.look({{0, 0, 0}, {0}});  // a seam holds both shells together
  EXPECT_EQ(ids.of_points(), Ids({{1, 1, 1}, {1}}));
  ids.look({{0, 0, 0}, {1}});
  EXPECT_EQ(ids.of_points(), Ids({{2, 2, 2}, {1}}));
}

TEST(PieceIds, PiecesThatBecomeOneHaveTheIdOfTheHeaviestAndNoIdComesTwice) {
  PieceIds ids = six();
  ids.look({{0, 0, 0, 0, 1, 1}});
  EXPECT_EQ(ids.of_points(), Ids({{10, 10, 10, 10, 11, 11}}));
  ids.look({{0, 0, 1, 1, 1, 1}});
  EXPECT_EQ(ids.of_points(), Ids({{10, 10, 11, 11, 11, 11}}));  // 10 and 11 are both there, with equal claims
  ids.look({{0, 0, 0, 0, 0, 0}});
  EXPECT_EQ(ids.of_points(), Ids({{11, 11, 11, 11, 11, 11}}));
  ids.look({{0, 0, 1, 1, 1, 1}});
  EXPECT_EQ(ids.of_points(), Ids({{12, 12, 11, 11, 11, 11}}));  // 10 has ended
}

TEST(PieceIds, ABodyTakesTheIdOfItsPieceAndKeepsIt) {
  PieceIds ids = six();
  ids.look({{0, 0, 1, 1, 1, -1}});
  EXPECT_EQ(ids.of_points(), Ids({{10, 10, 11, 11, 11, 0}}));
  EXPECT_EQ(ids.take({{0, 0}, {0, 1}}), 10u);
  ids.look({{-1, -1, 0, 0, 0, -1}});
  EXPECT_EQ(ids.of_points(), Ids({{10, 10, 11, 11, 11, 0}}));
  ids.look({{-1, 0, 1, 1, 1, 2}});  // a point that comes back does not bring the id of the body
  EXPECT_EQ(ids.of_points(), Ids({{10, 12, 11, 11, 11, 13}}));
  EXPECT_EQ(ids.take({}), 14u);                        // a splinter without control points
  EXPECT_EQ(ids.take({{0, 1}, {0, 2}, {0, 3}}), 11u);  // what an interlayer held together: its heaviest piece
  EXPECT_EQ(ids.take({{0, 4}}), 15u);                  // whose id a body has
  EXPECT_EQ(ids.take({{0, 2}}, {11u}), 11u);           // another shell of that piece
}

TEST(PieceIds, GoesOnFromACheckpoint) {
  PieceIds ids = six(), other = six();
  ids.look({{0, 0, 1, 1, 1, 2}});
  ids.take({{0, 0}});
  ArchiveWriter out;
  archive_one(out, ids);
  ArchiveReader in(out.bytes.data(), out.bytes.size());
  archive_one(in, other);
  EXPECT_EQ(in.left(), 0u);
  for (PieceIds* p : {&ids, &other}) {
    p->look({{0, 0, 1, 2, 2, 3}});
    EXPECT_EQ(p->take({{0, 0}}), 13u);
  }
  EXPECT_EQ(ids.of_points(), other.of_points());
}
