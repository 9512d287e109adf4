// The program of an engine of one's own. The excerpt of rigid/README.md stands here as it is there, and is compiled.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/error.h"
#include "coupler/link/engine_main.h"

namespace sunder::own_engine {

// clang-format off
struct MyEngine final : link::Engine {
  link::EngineInfo info() const override { return {"mine", "1.0", {"spheres", "contact", "double_precision"}}; }
  void add(const RigidBody& body) override;  // throw Error(…, "bad_body", …) for a shape that you lack
  void set_contact_laws(const std::vector<ContactLaw>& laws) override;
  void advance(double window_s, const std::vector<link::Motion>& predicted, const std::vector<BodyId>& solved) override;
  std::vector<link::State> states() const override;  // bodies that are not static, by ascending id
};                                                   // add_joint, release_joint, rows, save, restore: with their capabilities
int main(int argc, char** argv) {
  return link::engine_main("mine", argc, argv, [] { return std::make_unique<MyEngine>(); });
}
// clang-format on

void MyEngine::add(const RigidBody& body) {
  throw Error(Exit::kBadInput, "bad_body", "body '" + body.name + "': this engine holds none; take another engine");
}
void MyEngine::set_contact_laws(const std::vector<ContactLaw>&) {}
void MyEngine::advance(double, const std::vector<link::Motion>&, const std::vector<BodyId>&) {}
std::vector<link::State> MyEngine::states() const { return {}; }

}  // namespace sunder::own_engine

namespace {

int started_with(std::vector<std::string> arguments) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  return sunder::own_engine::main(static_cast<int>(arguments.size()), argv.data());
}

}  // namespace

TEST(EngineMain, AnEngineOfOnesOwnReadsTheCommandLineOfTheLauncher) {
  EXPECT_EQ(started_with({"mine"}), 2);  // no endpoint
  EXPECT_EQ(started_with({"mine", "--endpoint"}), 2);
  EXPECT_EQ(started_with({"mine", "--no-such-option"}), 2);
  EXPECT_EQ(started_with({"mine", "--engine", "mine", "--check"}), 0);
}

TEST(EngineMain, WhatAnEngineDoesNotOverrideItCannotDo) {
  sunder::own_engine::MyEngine engine;
  EXPECT_TRUE(engine.info().can("spheres"));
  try {
    engine.save();
    ADD_FAILURE() << "not refused";
  } catch (const sunder::Error& e) {
    EXPECT_EQ(e.kind, "no_capability");
    EXPECT_EQ(std::string(e.what()), "mine cannot do 'save_restore' (save)");
  }
}
