// What a run says of its own energies.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/io/audit.h"

using namespace sunder::shell;

namespace {

Audit sound() {
  Audit a;
  a.scale = 100.0, a.residual = -0.019, a.given = 4.9, a.coupling = 9.0, a.frozen = 9.0;
  a.book.healing = -1.9, a.book.handoff = -1.9;
  return a;
}

std::string said(const Audit& a) {
  const std::vector<std::string> all = doubts(a);
  EXPECT_EQ(all.size(), 1u);
  return all.empty() ? "" : all.front();
}

}  // namespace

TEST(Audit, WhatIsWithinItsBoundsIsNotSpokenOf) {
  EXPECT_TRUE(doubts(sound()).empty());
  Audit takes = sound();  // what contact and hand-offs take is theirs
  takes.book.contact = takes.book.handoff = takes.book.healing = 90.0;
  EXPECT_TRUE(doubts(takes).empty());
  Audit still = sound();
  still.scale = 0.0;
  EXPECT_TRUE(doubts(still).empty());
}

TEST(Audit, EnergyThatIsMissingOrMadeIsNamedWithItsShare) {
  for (const double residual : {0.12, -0.12}) {
    Audit a = sound();
    a.residual = residual;
    EXPECT_NE(said(a).find("books miss"), std::string::npos);
    EXPECT_NE(said(a).find(residual > 0.0 ? " 12.0 %" : "-12.0 %"), std::string::npos);
  }
  Audit a = sound();
  a.residual = std::nan("");
  EXPECT_NE(said(a).find("books miss"), std::string::npos);
  // books that close by a term that can only take
  a = sound(), a.given = 400.0;
  EXPECT_NE(said(a).find("contact has given back 400.0 %"), std::string::npos);
  a = sound(), a.book.healing = -3.0;
  EXPECT_NE(said(a).find("healed has made 3.0 %"), std::string::npos);
  a = sound(), a.book.handoff = -3.0;
  EXPECT_NE(said(a).find("3.0 % more energy"), std::string::npos);
  EXPECT_EQ(said(a).find("grid"), std::string::npos);
  a.grid_transfer = true;
  EXPECT_NE(said(a).find("grid"), std::string::npos);
}

TEST(Audit, WhatAWindowOrAFreezeLeavesOpenIsNamedWithItsRemedy) {
  Audit a = sound();
  a.coupling = 11.0;
  EXPECT_NE(said(a).find("11.0 % of the energy there was is uncertain"), std::string::npos);
  EXPECT_NE(said(a).find("window_s"), std::string::npos);
  a = sound(), a.frozen = 11.0;
  EXPECT_NE(said(a).find("11 %"), std::string::npos);
  EXPECT_NE(said(a).find("latest_freeze_s"), std::string::npos);
}
