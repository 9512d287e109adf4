// The suite can fail: each fault of wrong-engine fails the case for it, and an engine without a fault passes.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <sys/wait.h>

#include <fmt/format.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace {

struct Outcome {
  int status = -1;
  std::string said;
  std::map<std::string, std::string> verdicts;  // by row
  std::map<std::string, std::string> notes;
};

/// Runs the suite with these arguments.
Outcome suite(const std::string& arguments) {
  const sunder::TemporaryFolder folder;
  const std::string json = folder.path + "/rows.json";
  FILE* pipe = popen(fmt::format("'{}' {} --json '{}' 2>&1", SUNDER_CONFORMANCE, arguments, json).c_str(), "r");
  Outcome out;
  char buffer[4096];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe)) out.said.append(buffer, n);
  const int s = pclose(pipe);
  out.status = WIFEXITED(s) ? WEXITSTATUS(s) : -1;
  std::stringstream text;
  text << std::ifstream(json).rdbuf();
  google::protobuf::Struct table;
  if (text.str().empty()) return out;
  EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(text.str(), &table).ok()) << text.str();
  for (const auto& value : table.fields().at("cases").list_value().values()) {
    const auto& row = value.struct_value().fields();
    out.verdicts[row.at("name").string_value()] = row.at("verdict").string_value();
    out.notes[row.at("name").string_value()] = row.at("note").string_value();
  }
  return out;
}

Outcome with_fault(const std::string& base, const std::string& fault, const std::string& name) {
  return suite(
      fmt::format("--engine '{}' --engine-arg --base --engine-arg {} --engine-arg --fault --engine-arg {} "
                  "--case {}",
                  WRONG_ENGINE, base, fault, name));
}

}  // namespace

TEST(Conformance, FindsEachFaultByTheRowForIt) {
  const struct {
    const char *base, *fault, *name, *fails, *passes;
  } cases[] = {
      {"bullet", "leaks", "collision_spheres", "linear", "met"},
      {"bullet", "bouncy", "collision_spheres", "gain", "linear"},
      {"bullet", "twists", "collision_boxes_frictional", "angular_rest", "angular"},
      {"bullet", "sticky", "restitution_sphere_floor", "e_0.5", "e_0"},
      {"bullet", "slippery", "friction_angle", "holds_0deg", ""},
      {"bullet", "hovers", "rest_box", "height", "drift"},
      {"bullet", "random", "deterministic", "states", ""},
      {"bullet", "unhinged", "joint_ball", "anchor", ""},
      {"bullet", "clinging", "joint_released", "flies", "others"},
      {"bullet", "rowless", "export_half_space", "count", "foreign"},
      {"bullet", "flipped", "export_half_space", "normal", "face"},
      {"bullet", "meddling", "solved_half_space", "solved", "not_solved"},
      {"freeflight", "stale", "free_flight_sphere", "pose", "mass"},
      {"freeflight", "late", "births", "birth", ""},
      {"freeflight", "forgetful", "save_restore", "states", ""},
      {"freeflight", "forgetful", "again", "states", ""},
      {"freeflight", "sieve", "collision_boxes_off_centre", "met", "linear"},
      {"freeflight", "sieve", "tunnelling_plate", "window_0.5ms", ""},
      {"freeflight", "misspells", "rules_words", "unknown", ""},
      {"freeflight", "polite", "rules_turn", "second_hello", ""},
      {"freeflight", "lingers", "rules_end", "bye", ""},
      {"freeflight", "echoes", "rules_turn", "sequence", "body_twice"},
  };
  for (const auto& c : cases) {
    const std::string name = c.name;
    Outcome wrong = with_fault(c.base, c.fault, name);
    EXPECT_EQ(wrong.status, 1) << c.fault << ": " << wrong.said;
    EXPECT_EQ(wrong.verdicts[name + "." + c.fails], "fail") << c.fault << ": " << wrong.said;
    if (*c.passes) {
      EXPECT_EQ(wrong.verdicts[name + "." + c.passes], "pass") << c.fault << ": " << wrong.said;
    }
  }
}

TEST(Conformance, PassesTheSameRowsWithoutAFault) {
  for (const char* name : {"collision_spheres", "restitution_sphere_floor", "friction_angle", "rest_box",
                           "deterministic", "export_half_space", "solved_half_space"}) {
    const Outcome right = with_fault("bullet", "none", name);
    EXPECT_EQ(right.status, 0) << right.said;
  }
  for (const char* name : {"free_flight_sphere", "births", "save_restore", "again", "rules_words", "rules_turn",
                           "rules_window", "rules_end"}) {
    const Outcome right = with_fault("freeflight", "none", name);
    EXPECT_EQ(right.status, 0) << right.said;
  }
}

TEST(Conformance, FreeFlightHoldsAllThatItDeclares) {
  const Outcome all = suite(fmt::format("--engine '{}' --engine-arg --engine --engine-arg freeflight", SUNDER_RIGID));
  EXPECT_EQ(all.status, 0) << all.said;
  EXPECT_GT(all.verdicts.size(), 60u);
}

TEST(Conformance, SkipsACaseByAMissingCapabilityAndNamesIt) {
  Outcome flight = with_fault("freeflight", "none", "joint_ball");
  EXPECT_EQ(flight.status, 0) << flight.said;
  EXPECT_EQ(flight.verdicts["joint_ball"], "skipped");
  EXPECT_NE(flight.notes["joint_ball"].find("'joints'"), std::string::npos) << flight.notes["joint_ball"];
  const Outcome flying = with_fault("freeflight", "none", "restitution_between_walls");
  EXPECT_EQ(flying.notes.at("restitution_between_walls"), "the engine does not declare 'contact', 'restitution'");
}

TEST(Conformance, HoldsAnEngineToTheListOfItsKnownFailures) {
  const std::string list = testing::TempDir() + "/conformance_known.txt";
  const auto with_list = [&](const std::string& lines, const std::string& fault) {
    std::ofstream(list) << lines;
    return with_fault("bullet", fault, fmt::format("collision_spheres --expect '{}'", list));
  };
  const std::string gain = "# a comment\n\ncollision_spheres.gain 100 it is bouncy\n";
  Outcome known = with_list(gain, "bouncy");
  EXPECT_EQ(known.verdicts["collision_spheres.gain"], "known") << known.said;
  EXPECT_NE(known.notes["collision_spheres.gain"].find("it is bouncy"), std::string::npos) << known.said;
  EXPECT_EQ(known.status, 0) << known.said;
  Outcome worse = with_list("collision_spheres.gain 1e-8 it is bouncy\n", "bouncy");
  EXPECT_EQ(worse.status, 1) << worse.said;
  EXPECT_EQ(worse.verdicts["collision_spheres.gain"], "fail") << worse.said;
  EXPECT_EQ(worse.notes["collision_spheres.gain"].find("known: "), std::string::npos) << worse.said;
  EXPECT_NE(worse.notes["collision_spheres.gain"].find("known up to 1e-08: it is bouncy"), std::string::npos)
      << worse.said;
  Outcome passes = with_list(gain, "none");
  EXPECT_EQ(passes.status, 1) << passes.said;
  EXPECT_EQ(passes.verdicts["collision_spheres.gain"], "fail") << passes.said;
  Outcome other = with_list("collision_spheres.met 2 because\n", "leaks");
  EXPECT_EQ(other.status, 1) << other.said;
  EXPECT_EQ(other.verdicts["collision_spheres.linear"], "fail") << other.said;
  EXPECT_EQ(with_list("collision_spheres.nonsense 1 because\n", "none").status, 1);      // no such row
  EXPECT_EQ(with_list("collision_boxes_elastic.energy 1 because\n", "none").status, 0);  // a case that did not run
  for (const std::string lacking : {"", " 1", " it is bouncy", " -1 it is bouncy", " inf it is bouncy", " 1x it is"})
    EXPECT_EQ(with_list("collision_spheres.gain" + lacking + "\n", "none").status, 2) << lacking;
  EXPECT_EQ(with_list(gain + gain, "none").status, 2);
  std::ofstream(list) << "restitution_spheres.ahead_1 0.2 it is late\n";
  EXPECT_EQ(with_fault("freeflight", "none", fmt::format("restitution_spheres --expect '{}'", list)).status,
            0);  // skipped
  std::filesystem::remove(list);
  EXPECT_EQ(suite(fmt::format("--engine '{}' --expect '{}'", WRONG_ENGINE, list)).status, 2);
  EXPECT_EQ(suite(fmt::format("--engine '{}' --leave-out nonsense", WRONG_ENGINE)).status, 2);
}

TEST(Conformance, AMistypedOptionOrCaseIsRefusedWithTheNearestRightOne) {
  const auto says = [](const std::string& arguments, const std::string& words) {
    const Outcome refused = suite(arguments);
    EXPECT_EQ(refused.status, 2) << refused.said;
    EXPECT_NE(refused.said.find(words), std::string::npos) << refused.said;
  };
  says("--engin x", "unknown option --engin (did you mean '--engine'");
  says(fmt::format("--engine '{}' --case rest_bok", SUNDER_RIGID), "no such case (did you mean 'rest_box'?)");
  says("--case rest_box", "give --engine or --endpoint");
}

TEST(Conformance, RefusesArgumentsThatCannotBe) {
  EXPECT_EQ(suite("").status, 2);
  EXPECT_EQ(suite("--engine a --endpoint b").status, 2);
  EXPECT_EQ(suite(fmt::format("--engine '{}' --case nonsense", WRONG_ENGINE)).status, 2);
  EXPECT_EQ(suite("--engine /nonexistent/engine").status, 3);
  EXPECT_EQ(suite("--engine /bin/false").status, 3);
}
