// Presets of materials.
#include "coupler/scene/presets.h"

#include <gtest/gtest.h>

#include "tests/coupler/small_scene.h"

using namespace sunder;
using namespace small_scene;

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
  EXPECT_EQ(m->branch_drive(), 13.7);
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

TEST(Presets, AndTheirFieldsAreRefusedWithTheReason) {
  const auto with = [](const std::string& more) {
    return replaced("poisson_ratio: 0.22", "poisson_ratio: 0.22 strength: 6e7 fracture_energy: 8 " + more);
  };
  const struct {
    const char *given, *field, *says;
  } cases[] = {{"crack_speed_onset: 1.5", "crack_speed_onset", "0 to 1"},
               {"crack_speed_onset: nan", "crack_speed_onset", "0 to 1"},
               {"toughening: 5", "toughening", "needs a crack_speed_onset"},
               {"crack_speed_onset: 0.4 toughening: 5", "toughening", "needs a branch_drive"},
               {"crack_speed_onset: 0.4 branch_drive: 9 toughening: -1", "toughening", "-1"},
               {"crack_speed_onset: 0.4 branch_drive: 9 toughening: inf", "toughening", "inf"},
               {"branch_drive: 1", "branch_drive", "more than 1"},
               {"branch_drive: nan", "branch_drive", "more than 1"},
               {"crack_friction: -0.1", "crack_friction", "0 to 10"},
               {"crack_friction: inf", "crack_friction", "0 to 10"},
               {"crack_speed_onset: 0.4 branch_drive: 9 toughening: 1e7", "toughening", "at most 1e6"},
               {"crushing_strength: 1e6", "crushing_strength", "below the strength"},
               {"crushing_strength: 0", "crushing_strength", "positive"},
               {"crushing_strength: inf", "crushing_strength", "positive"}};
  for (const auto& c : cases) expect_refusal(with(c.given), std::string("materials[0].") + c.field, {c.says});
  EXPECT_NE(std::string(refusal(with("interlock_strength: 1e6")).what()).find("crack_friction"), std::string::npos);
  expect_refusal(with("preset: GLAS"), "preset", {"SODA_LIME_GLASS"});
}
