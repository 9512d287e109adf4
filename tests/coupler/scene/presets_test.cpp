// Presets of materials.
#include "coupler/scene/presets.h"

#include <gtest/gtest.h>

#include "tests/coupler/small_scene.h"

using namespace sunder;

TEST(Presets, FillInWhatIsLeftOutAndNothingElse) {
  proto::Scene scene;
  proto::Material* m = scene.add_materials();
  m->set_name("pane"), m->set_preset(proto::Material::SODA_LIME_GLASS);
  m->set_fracture_energy(9.0), m->set_toughening(0.0);
  scene::fill_presets(scene);
  EXPECT_EQ(m->name(), "pane");
  EXPECT_EQ(m->density(), 2500.0);
  EXPECT_EQ(m->youngs_modulus(), 70e9);
  EXPECT_EQ(m->fracture_energy(), 9.0);
  EXPECT_EQ(m->toughening(), 0.0);
  EXPECT_EQ(m->branch_drive(), 12.0);
  EXPECT_FALSE(m->has_strength());  // of a surface, not of a material
}

TEST(Presets, AllHaveWhatAShellThatBreaksNeeds) {
  const auto* presets = proto::Material::Preset_descriptor();
  ASSERT_GT(presets->value_count(), 2);
  for (int k = 0; k < presets->value_count(); ++k) {
    proto::Scene scene;
    proto::Material* m = scene.add_materials();
    m->set_preset(static_cast<proto::Material::Preset>(presets->value(k)->number()));
    scene::fill_presets(scene);
    if (presets->value(k)->number() == 0) {
      EXPECT_FALSE(m->has_density());
      continue;
    }
    EXPECT_TRUE(m->has_density() && m->has_youngs_modulus() && m->has_poisson_ratio() && m->has_fracture_energy());
    EXPECT_TRUE(m->has_crack_speed_onset() && m->has_toughening() && m->has_branch_drive());
    // the energy balance of a tip holds at its division: (1 - v) g_b = 1 + k (v - onset), at half the Rayleigh speed
    EXPECT_NEAR(0.5 * m->branch_drive(), 1.0 + m->toughening() * (0.5 - m->crack_speed_onset()), 0.01);
  }
}
