// What contact between shells may give: no more than it has taken, but for what parts an overlap of the start.
#include <gtest/gtest.h>

#include "shell/solver/contact/shell_contact.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/rig.h"

using namespace sunder;
using namespace sunder::shell;

// Two layers whose borders are held in overlap: what is taken back beside the borders comes again in every substep.
TEST(ShellContact, AnOverlapThatStaysMakesNoMoreEnergyThanItsRecoveryNeeds) {
  ShellMaterial cloth;
  cloth.density = 20, cloth.youngs_modulus = 3200, cloth.poisson_ratio = 0.3;
  Support held;
  held.edges = kUMin | kUMax | kVMin | kVMax;
  const auto layer = [&](double z) {
    return make_shell("cloth", plate(0.06, 0.06, 20, 20, Vec3(0, 0, z), Quat::Identity()), 0.005, cloth, 2, 2, {held});
  };
  for (const double safety : {0.4, 0.2}) {
    Rig rig(setup_of({{layer(0.0)}, {layer(0.002)}}));
    rig.meet();
    const double dt = safety * stable_step(rig.model(0), rig.state(0), 60, 1, false);
    for (double t = 0.0; t < 0.02; t += dt) rig.step(dt);
    const ShellContact& contact = *rig.now().contact;
    EXPECT_GT(contact.taken(), -2.0 * contact.lent());  // what is lent, and less than as much in the last substep
    EXPECT_LT(contact.taken(), -contact.lent());        // it is spent
    ArchiveWriter out;
    rig.now().contact->archive_state(out);
    Rig later(setup_of({{layer(0.0)}, {layer(0.002)}}));
    later.meet();
    ArchiveReader in(out.bytes.data(), out.bytes.size());
    later.now().contact->archive_state(in);
    EXPECT_EQ(later.now().contact->taken(), contact.taken());  // it stays spent in a run that goes on
  }
}
