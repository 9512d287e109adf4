// Which faces of a CAD file are turned over: by edges that two faces share, and by free edges that run together.
#include "shell/io/cad_sides.h"

#include <gtest/gtest.h>

using namespace sunder;
using namespace sunder::shell;

namespace {

using Numbers = std::vector<int>;

// An edge from a to b; `senses` as in CadEdge.
CadEdge edge_of_faces(const Numbers& faces, const Numbers& senses, const Vec3& a = Vec3::Zero(),
                      const Vec3& b = Vec3::UnitX()) {
  CadEdge e;
  e.faces = faces, e.senses = senses, e.length = (b - a).norm(), e.middle = 0.5 * (a + b);
  for (int k = 0; k <= 4; ++k) e.points.push_back(a + 0.25 * k * (b - a));
  return e;
}
// An edge that two faces share and that is run through in opposite directions: their normals agree.
CadEdge agreeing(int a, int b) { return edge_of_faces({a, b}, {1, -1}); }
CadEdge opposed(int a, int b) { return edge_of_faces({a, b}, {1, 1}); }

}  // namespace

TEST(CadSides, FacesThatAgreeOrStandAloneStay) {
  EXPECT_EQ(faces_to_turn({}, {}), Numbers());
  EXPECT_EQ(faces_to_turn({}, {0, 1, 2}), Numbers());
  EXPECT_EQ(faces_to_turn({agreeing(0, 1), agreeing(1, 2), agreeing(2, 0)}, {0, 1, 2}), Numbers());
}

TEST(CadSides, TheFewerAreTurned) {
  EXPECT_EQ(faces_to_turn({agreeing(0, 1), opposed(1, 2)}, {0, 1, 2}), Numbers{2});
  EXPECT_EQ(faces_to_turn({opposed(0, 1), agreeing(1, 2)}, {0, 1, 2}), Numbers{0});
  EXPECT_EQ(faces_to_turn({opposed(0, 1), opposed(1, 2)}, {0, 1, 2}), Numbers{1});
  // of two halves, the one without the lowest number
  EXPECT_EQ(faces_to_turn({opposed(3, 5)}, {5, 3}), Numbers{5});
  EXPECT_EQ(faces_to_turn({agreeing(0, 3), opposed(0, 1), agreeing(1, 2)}, {0, 1, 2, 3}), (Numbers{1, 2}));
}

TEST(CadSides, EachConnectedGroupIsJudgedByItself) {
  EXPECT_EQ(faces_to_turn({opposed(0, 1), agreeing(1, 2), opposed(7, 8), agreeing(8, 9)}, {0, 1, 2, 7, 8, 9}),
            (Numbers{0, 7}));
}

TEST(CadSides, OnlyFacesThatAreTakenCount) {
  // 1 lies between 0 and 2, and is not taken
  EXPECT_EQ(faces_to_turn({opposed(0, 1), agreeing(1, 2)}, {0, 2}), Numbers());
  EXPECT_EQ(faces_to_turn({opposed(0, 2), agreeing(1, 2)}, {0, 2}), Numbers{2});
}

// A strip of three faces that closes with half a turn has one side.
TEST(CadSides, FacesWithoutTwoSidesStay) {
  EXPECT_EQ(faces_to_turn({agreeing(0, 1), agreeing(1, 2), opposed(2, 0)}, {0, 1, 2}), Numbers());
  EXPECT_EQ(faces_to_turn({opposed(0, 1), opposed(1, 2), opposed(2, 0)}, {0, 1, 2}), Numbers());
  EXPECT_EQ(faces_to_turn({opposed(0, 0)}, {0}), Numbers());  // a strip of one face
  // another group beside it is judged all the same
  EXPECT_EQ(faces_to_turn({agreeing(0, 1), opposed(1, 0), opposed(4, 5)}, {0, 1, 4, 5}), Numbers{5});
}

TEST(CadSides, AnEdgeAtWhichAFaceMeetsItselfSaysNothing) {
  EXPECT_EQ(faces_to_turn({edge_of_faces({0, 0}, {0, 0}), agreeing(0, 1)}, {0, 1}), Numbers());
  EXPECT_EQ(faces_to_turn({edge_of_faces({0, 1}, {0, 1})}, {0, 1}), Numbers());
  EXPECT_EQ(faces_to_turn({edge_of_faces({0, 1, 2}, {1, 1, 1})}, {0, 1, 2}), Numbers());  // of three sheets
}

// Loose faces of an IGES file have an edge each. They agree where their borders run in opposite directions.
TEST(CadSides, FreeEdgesThatRunTogetherJoinFaces) {
  const Vec3 a(0, 0, 0), b(1, 0, 0);
  for (const int first : {1, -1})
    for (const int second : {1, -1})
      for (const bool reversed : {false, true}) {
        const CadEdge one = edge_of_faces({0}, {first}, a, b),
                      two = reversed ? edge_of_faces({1}, {second}, b, a) : edge_of_faces({1}, {second}, a, b);
        const bool same_direction = first * second * (reversed ? -1 : 1) > 0;
        EXPECT_EQ(faces_to_turn({one, two}, {0, 1}), same_direction ? Numbers{1} : Numbers());
      }
}

// A thousandth of the length may lie between them.
TEST(CadSides, FreeEdgesThatAreApartSayNothing) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), up = Vec3::UnitZ();
  const auto turned = [&](const CadEdge& other) {
    return faces_to_turn({edge_of_faces({0}, {1}, a, b), other}, {0, 1});
  };
  EXPECT_EQ(turned(edge_of_faces({1}, {1}, a + 0.9e-3 * up, b + 0.9e-3 * up)), Numbers{1});
  EXPECT_EQ(turned(edge_of_faces({1}, {1}, a + 1.1e-3 * up, b + 1.1e-3 * up)), Numbers());
  EXPECT_EQ(turned(edge_of_faces({1}, {1}, a, b + Vec3(0.9e-3, 0, 0))), Numbers{1});
  EXPECT_EQ(turned(edge_of_faces({1}, {1}, a, b + Vec3(1.1e-3, 0, 0))), Numbers());  // longer
  CadEdge bent = edge_of_faces({1}, {1}, a, b);  // between the same ends another way
  bent.middle += 0.09 * up;
  EXPECT_EQ(turned(bent), Numbers{1});
  bent.middle += 0.02 * up;
  EXPECT_EQ(turned(bent), Numbers());
}

TEST(CadSides, FreeEdgesThatAreClosedOrOfOneFaceSayNothing) {
  const Vec3 a(0, 0, 0), b(1, 0, 0);
  CadEdge one = edge_of_faces({0}, {1}, a, b), two = edge_of_faces({1}, {1}, a, b);
  for (CadEdge* e : {&one, &two}) e->points.back() = e->points.front();  // a circle has no direction that ends tell
  EXPECT_EQ(faces_to_turn({one, two}, {0, 1}), Numbers());
  const CadEdge slit = edge_of_faces({0}, {1}, a, b);
  EXPECT_EQ(faces_to_turn({slit, slit}, {0, 1}), Numbers());
}
