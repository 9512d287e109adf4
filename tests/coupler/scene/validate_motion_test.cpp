// Bodies that follow a prescribed motion or change their shape: refusals with field and remedy.
#include <cmath>
#include <cstring>
#include <limits>

#include "coupler/scene/mesh.h"
#include "tests/coupler/arch.h"
#include "tests/coupler/small_scene.h"

using namespace small_scene;

namespace {

std::string moved(const std::string& motion, const std::string& more = "") {
  return replaced("  pose { position { z: 0.1 } }\n", "  " + motion + "\n  " + more + "\n");
}

const std::string kDown = "motion { position { z: 0.1 } } motion { time_s: 0.5 position { z: 0.03 } }";

TEST(Motion, IsAcceptedWithKeysOfAllKinds) {
  EXPECT_EQ(refusal(moved(kDown)).kind, "accepted") << refusal(moved(kDown)).what();
  EXPECT_EQ(
      refusal(moved("motion { position { z: 0.1 } orientation { w: 1 } } motion { time_s: 0.5 position { z: 0.2 } "
                    "rotation { axis { x: 1 y: 1 } angle_deg: 400 } } motion { time_s: 1 position { z: 0.1 } "
                    "twist { linear { z: -1 } angular { x: 3 } } }"))
          .kind,
      "accepted");
  // a body that its motion moves needs no density
  EXPECT_EQ(refusal(replaced("  material: \"glass\"\n  sphere { radius_m: 0.02 }\n  pose { position { z: 0.1 } }\n",
                             "  sphere { radius_m: 0.02 }\n  " + kDown + "\n"))
                .kind,
            "accepted");
}

TEST(Motion, ExcludesWhatItMakesMeaningless) {
  expect_refusal(moved(kDown, "pose { position { z: 0.1 } }"), "bodies[0].pose",
                 {"whose first key says", "leave it out"});
  expect_refusal(moved(kDown, "twist { linear { z: -1 } }"), "bodies[0].twist", {"give a key a twist"});
  expect_refusal(moved(kDown, "launch { speed: 1 target: \"pane\" }"), "bodies[0].launch", {"leave one of them out"});
  expect_refusal(moved(kDown, "is_static: true"), "bodies[0].motion", {"'ball' is static"});
  expect_refusal(replaced("sphere { radius_m: 0.02 }\n  pose { position { z: 0.1 } }", "half_space {}\n  " + kDown),
                 "bodies[0].motion", {"a half space never moves; take a box"});
  for (const std::string scheme : {"ITERATED", "STAGGERED", "LAGGED"})
    expect_refusal(moved(kDown) + "coupling { scheme: " + scheme + " }\n", "coupling.scheme",
                   {"is " + scheme + ", by which the engine's impulses move bodies", "whatever pushes it",
                    "take PROXY or EXPORTED"});
  expect_refusal(moved(kDown) + "joints { name: \"j\" kind: BALL first: \"ball\" }\n", "joints[0].first",
                 {"name a body that moves freely"});
}

TEST(Motion, OfWrongTimesOrPosesIsRefused) {
  expect_refusal(moved("motion { time_s: 0.2 position { z: 0.1 } } motion { time_s: 0.2 position { z: 0.1 } }"),
                 "bodies[0].motion[1].time_s", {"is 0.2 s, and 0.2 s in the key before", "times must rise"});
  expect_refusal(moved("motion { time_s: -1 position { z: 0.1 } }"), "bodies[0].motion[0].time_s",
                 {"give seconds from 0 on"});
  expect_refusal(moved("motion { position { z: 0.1 } orientation { w: 2 } }"), "bodies[0].motion[0].orientation",
                 {"has length 2"});
  expect_refusal(moved("motion { position { z: nan } }"), "bodies[0].motion[0].position", {"must be finite"});
  expect_refusal(moved("motion { position { z: 0.1 } rotation { axis { } angle_deg: 3 } }"),
                 "bodies[0].motion[0].rotation.axis", {"has no direction"});
  expect_refusal(
      moved("motion { position { z: 0.1 } } motion { time_s: 0.5 position { z: 0.2 } twist { linear { z: 1 } } }"),
      "bodies[0].motion[1].twist", {"in the last key, after which it rests", "end_time_s or later"});
  expect_refusal(moved("motion { time_s: 0.1 position { z: 0.1 } twist { linear { z: 1 } } }"),
                 "bodies[0].motion[0].twist", {"before which it rests; begin at time_s 0"});
  std::string many;
  for (int k = 0; k <= 100000; ++k) many += fmt::format("motion {{ time_s: {} position {{ z: 0.1 }} }} ", k * 1e-5);
  expect_refusal(moved(many), "bodies[0].motion", {"has 100001 keys; at most 100000"});
}

TEST(Motion, ThatJumpsOrStartsInsideAShellIsRefused) {
  // 0.07 m in 0.1 ms is 1.5 times 700 m/s in the middle; a window may take the ball by its width, 0.04 m
  const std::string jump = moved("motion { position { z: 0.1 } } motion { time_s: 1e-4 position { z: 0.03 } }");
  expect_refusal(jump, "bodies[0].motion", {"jumps", "further than it is wide, 0.04 m", "or a window_s of 1.9e-05 s"});
  EXPECT_EQ(refusal(jump, {"window_s=1.9e-5"}).kind, "accepted");
  expect_refusal(moved("motion { position { z: 0.1 } } motion { time_s: 1e-7 position { z: 0.03 } }"),
                 "bodies[0].motion", {"jumps", "a shell takes no window short enough"});
  expect_refusal(moved("motion { position { z: 0.1 } } motion { time_s: 1e-7 position { z: 1e305 } }"),
                 "bodies[0].motion", {"faster than numbers can say"});
  expect_refusal(moved("motion { position { z: 0.01 } } motion { time_s: 0.5 position { z: 0.3 } }"),
                 "bodies[0].motion", {"m inside shell 'pane'", "; move it 0.0"});
}

// A stiff pane takes long substeps, in which the ball passes it.
TEST(Motion, FasterThanASubstepIsRefusedWithAStepThatDoes) {
  const std::string shot =
      replaced("pose { position { z: 0.1 } }", "pose { position { z: 0.2 } } twist { linear { z: -15000 } }");
  const auto coarse = [](std::string text) {
    const std::string fine = "elements_x: 16 elements_y: 16", small = "radius_m: 0.02";
    text.replace(text.find(small), small.size(), "radius_m: 0.07");
    return text.replace(text.find(fine), fine.size(), "elements_x: 4 elements_y: 4");
  };
  std::string said;
  try {
    report(coarse(shot));
  } catch (const sunder::Error& e) {
    said = e.what();
  }
  const std::string remedy = "slow it down, or take a time_step_safety of ";
  const std::size_t at = said.find(remedy);
  ASSERT_NE(at, std::string::npos) << said;
  const double safety = std::stod(said.substr(at + remedy.size()));
  EXPECT_GT(safety, 0.05);
  EXPECT_NO_THROW(report(coarse(shot) + fmt::format("time_step_safety: {}\n", safety)));
  std::string faster = coarse(shot);
  faster.replace(faster.find("-15000"), 6, "-1.5e6");
  try {
    report(faster);
    ADD_FAILURE() << "accepted";
  } catch (const sunder::Error& e) {
    EXPECT_NE(std::string(e.what()).find("shells are not solved in steps so short"), std::string::npos) << e.what();
  }
}

struct Files {
  std::vector<std::string> names;
  void write(const std::string& name, const std::string& text) {
    names.push_back(own_file(name));
    std::ofstream(names.back()) << text;
  }
  std::string name(std::size_t k) const { return names[k].substr(names[k].rfind('/') + 1); }
  ~Files() {
    for (const std::string& n : names) std::remove(n.c_str());
  }
};

std::string deforming(const Files& files, const std::string& deformation,
                      const std::string& more = "surface: EXACT }") {
  return replaced("sphere { radius_m: 0.02 }", "mesh { path: \"" + files.name(0) + "\" scale: 2 " + more +
                                                   "\n  deformation { " + deformation + " }");
}

TEST(Deformation, IsAcceptedAndRefusedWithItsPlace) {
  Files files;
  arch::Mesh mesh = arch::mesh();
  files.write("arch.obj", arch::obj(mesh));
  const std::string inflate = "inflate { } inflate { time_s: 0.5 distance_m: 0.005 }";
  EXPECT_EQ(refusal(deforming(files, inflate)).kind, "accepted") << refusal(deforming(files, inflate)).what();
  expect_refusal(deforming(files, inflate, "}"), "bodies[0].deformation", {"surface: EXACT"});
  expect_refusal(deforming(files, ""), "bodies[0].deformation", {"neither inflate nor shapes"});
  expect_refusal(deforming(files, inflate + " shapes { time_s: 0.5 path: \"x.obj\" }"), "bodies[0].deformation",
                 {"both inflate and shapes"});
  expect_refusal(deforming(files, inflate + " } is_static: true #"), "bodies[0].deformation", {"is static"});
  expect_refusal(deforming(files, inflate + " } twist { linear { z: 1 }"), "bodies[0].twist", {"or give motion"});
  expect_refusal(deforming(files, inflate + " } launch { speed: 1 target: \"pane\""), "bodies[0].launch",
                 {"or give motion"});
  expect_refusal(deforming(files, "inflate {} inflate { time_s: 1 distance_m: nan }"),
                 "bodies[0].deformation.inflate[1].distance_m", {"must be finite"});
  std::string many;
  for (int k = 0; k <= 1000; ++k) many += fmt::format("shapes {{ time_s: {} path: \"x.obj\" }} ", k + 1);
  expect_refusal(deforming(files, many), "bodies[0].deformation.shapes", {"has 1001 entries; at most 1000"});
  expect_refusal(deforming(files, "shapes { time_s: 1 }"), "bodies[0].deformation.shapes[0].path", {"name a mesh"});
  expect_refusal(
      deforming(files, inflate) +
          "bodies { name: \"bob\" material: \"glass\" sphere { radius_m: 0.02 } pose { position { z: 0.5 } } }\n"
          "joints { name: \"j\" kind: BALL first: \"bob\" second: \"ball\" }\n",
      "joints[0].second", {"name another body"});
  expect_refusal(deforming(files, "inflate { distance_m: 0.001 } inflate { time_s: 1 }"),
                 "bodies[0].deformation.inflate[0].distance_m", {"it begins at 0"});
  expect_refusal(deforming(files, "inflate { time_s: 1 } inflate { time_s: 0.5 }"),
                 "bodies[0].deformation.inflate[1].time_s", {"times must rise"});
  // The feet are 0.04 m apart, and each grows by 0.025 m towards the other.
  expect_refusal(deforming(files, "inflate { } inflate { time_s: 0.5 distance_m: 0.04 }"),
                 "bodies[0].deformation.inflate[1].distance_m",
                 {"is 0.04 m, too far for this surface", "crosses itself", "give a smaller distance"});
  expect_refusal(deforming(files, "inflate { } inflate { time_s: 1e-6 distance_m: 0.005 }"), "bodies[0].deformation",
                 {"jumps"});
  expect_refusal(deforming(files, inflate) + "joints { name: \"j\" kind: BALL first: \"ball\" }\n", "joints[0].first",
                 {"name a body that moves freely"});
}

TEST(Deformation, IsRefusedWhereItTurnsInsideOutOrCollapsesOnTheWay) {
  Files files;
  const arch::Mesh mesh = arch::mesh();
  files.write("arch.obj", arch::obj(mesh));
  sunder::Vec3 middle = sunder::Vec3::Zero();
  for (const sunder::Vec3& p : mesh.points) middle += p / static_cast<double>(mesh.points.size());
  std::size_t count = 0;
  const auto expect = [&](const sunder::Mat3& map, const std::string& place, const std::string& word) {
    arch::Mesh mapped = mesh;
    for (sunder::Vec3& p : mapped.points) p = middle + map * (p - middle);
    files.write("mapped" + std::to_string(++count) + ".obj", arch::obj(mapped));
    const std::string scene = deforming(files, "shapes { time_s: 0.5 path: \"" + files.name(count) + "\" }");
    if (place.empty())
      EXPECT_EQ(refusal(scene).kind, "accepted") << refusal(scene).what();
    else
      expect_refusal(scene, place, {word});
  };
  const auto turn = [](double degrees) {
    return Eigen::AngleAxisd(degrees * M_PI / 180.0, sunder::Vec3::UnitZ()).toRotationMatrix();
  };
  expect(sunder::Vec3(1, 1, -1).asDiagonal(), "bodies[0].deformation.shapes[0]", "inside out");
  expect(turn(180), "bodies[0].deformation.shapes[0]", "give more shapes between the two, or turn it by motion");
  expect(turn(150), "bodies[0].deformation.shapes[0]", "give more shapes between the two, or turn it by motion");
  expect(turn(60), "", "");
  expect_refusal(deforming(files, "inflate { } inflate { time_s: 0.5 distance_m: -0.08 }"),
                 "bodies[0].deformation.inflate[1]", {"smaller"});
  expect_refusal(deforming(files, "inflate { } inflate { time_s: 0.5 distance_m: 1e300 }"),
                 "bodies[0].deformation.inflate[1].distance_m",
                 {"too far for this surface", "give a smaller distance"});
}

TEST(Deformation, ShapesHaveThePointsAndFacesOfTheMesh) {
  Files files;
  arch::Mesh mesh = arch::mesh();
  files.write("arch.obj", arch::obj(mesh));
  for (sunder::Vec3& p : mesh.points) p *= 1.2;
  files.write("larger.obj", arch::obj(mesh));
  const auto shape = [&](std::size_t k) {
    return deforming(files, "shapes { time_s: 0.5 path: \"" + files.name(k) + "\" }");
  };
  EXPECT_EQ(refusal(shape(1)).kind, "accepted") << refusal(shape(1)).what();
  arch::Mesh fewer = mesh;
  fewer.faces.pop_back();
  files.write("fewer.obj", arch::obj(fewer));
  expect_refusal(shape(2), "bodies[0].deformation.shapes[0].path", {"has 9 faces, and", "has 10", "in one order"});
  arch::Mesh turned = mesh;
  std::rotate(turned.faces[3].begin(), turned.faces[3].begin() + 1, turned.faces[3].end());
  files.write("turned.obj", arch::obj(turned));
  expect_refusal(shape(3), "bodies[0].deformation.shapes[0].path", {"has in line 21 a face of other points than"});
  arch::Mesh crossed = mesh;
  crossed.points[0] = {0.2, 0.01, 0.0};
  files.write("crossed.obj", arch::obj(crossed));
  expect_refusal(shape(4), "bodies[0].deformation.shapes[0].path", {"crosses itself"});
  expect_refusal(deforming(files, "shapes { time_s: 0.5 path: \"none.obj\" }"), "bodies[0].deformation.shapes[0].path",
                 {"cannot be read"});
  expect_refusal(deforming(files, "shapes { path: \"" + files.name(1) + "\" }"),
                 "bodies[0].deformation.shapes[0].time_s", {"give a later time"});
}

// The points of the arch, and of an arch that has grown by a fifth.
std::vector<std::vector<sunder::Vec3>> growing() {
  std::vector<std::vector<sunder::Vec3>> out(2, arch::mesh().points);
  for (sunder::Vec3& p : out[1]) p *= 1.2;
  return out;
}

TEST(Deformation, OfACacheIsThatOfItsShapes) {
  Files files;
  files.write("arch.obj", arch::obj(arch::mesh()));
  arch::Mesh larger = arch::mesh();
  larger.points = growing()[1];
  files.write("larger.obj", arch::obj(larger));
  files.write("grows.pc2", arch::pc2(growing(), 5.0f, 2.5f));
  const auto read = [&](const std::string& deformation) {
    const std::string path = own_file("scene.textproto");
    std::ofstream(path) << deforming(files, deformation);
    const auto scene = sunder::scene::load(path, {});
    std::remove(path.c_str());
    return sunder::scene::read_shapes(scene, "bodies[0]", scene.message.bodies(0));
  };
  const std::string cache = "cache { path: \"" + files.name(2) + "\" frames_per_second: 10 ";
  const auto shapes = read("shapes { time_s: 0.5 path: \"" + files.name(1) + "\" }");
  const auto cached = read(cache + "}");
  EXPECT_EQ(cached.times, (std::vector<double>{0.5, 0.75}));
  EXPECT_EQ(read(cache + "time_s: 0 }").times, (std::vector<double>{0.0, 0.25}));
  ASSERT_EQ(cached.corners.size(), shapes.corners.size());
  EXPECT_EQ(cached.surface.triangles, shapes.surface.triangles);
  for (std::size_t k = 0; k < shapes.corners.size(); ++k) {
    ASSERT_EQ(cached.corners[k].size(), shapes.corners[k].size());
    for (std::size_t i = 0; i < shapes.corners[k].size(); ++i)  // single precision
      EXPECT_LT((cached.corners[k][i] - shapes.corners[k][i]).norm(), 1e-8);
  }
  EXPECT_EQ(cached.surface.corners, cached.corners[0]);
  EXPECT_EQ(refusal(deforming(files, cache + "}")).kind, "accepted") << refusal(deforming(files, cache + "}")).what();
}

TEST(Deformation, OfACacheThatDoesNotFitIsRefused) {
  Files files;
  files.write("arch.obj", arch::obj(arch::mesh()));
  const std::string good = arch::pc2(growing(), 0.0f, 12.0f), field = "bodies[0].deformation.cache";
  const auto expect = [&](const std::string& bytes, const std::vector<std::string>& words,
                          const std::string& more = "frames_per_second: 24") {
    files.write(fmt::format("cache{}.pc2", files.names.size()), bytes);
    const std::string scene =
        deforming(files, "cache { path: \"" + files.name(files.names.size() - 1) + "\" " + more + " }");
    if (words.empty())
      EXPECT_EQ(refusal(scene).kind, "accepted") << refusal(scene).what();
    else
      expect_refusal(scene, field + ".path", words);
  };
  const auto with = [&](std::size_t at, auto number) {
    std::string out = good;
    std::memcpy(&out[at], &number, sizeof number);
    return out;
  };
  expect(good, {});
  expect("", {"is no PC2 file", "export the animation as PC2"});
  expect(good.substr(0, 31), {"is no PC2 file"});
  expect(with(3, 'X'), {"is no PC2 file"});
  expect(with(12, std::int32_t{2}), {"is of version 2", "version 1 is read"});
  for (const std::int32_t points : {15, 17, 0, -16, 0x7fffffff})
    expect(with(16, points), {fmt::format("has {} points, and '", points), "has 16", "without modifiers"});
  for (const std::int32_t samples : {0, -1, 1001, 0x7fffffff})
    expect(with(28, samples), {fmt::format("has {} samples; give 1 to 1000", samples), "fewer samples"});
  for (const std::int32_t samples : {1, 3, 1000}) expect(with(28, samples), {"bytes, and", "is the copy whole?"});
  expect(good.substr(0, good.size() - 1), {"has 415 bytes, and 2 samples of 16 points take 416"});
  expect(good + "x", {"has 417 bytes"});
  for (const float rate : {0.0f, -1.0f, std::nanf(""), std::numeric_limits<float>::infinity()})
    expect(with(24, rate), {"frames from sample to sample", "sample rate above 0"});
  expect(with(20, -10.0f), {"begins at frame -10, before time 0", "time_s"});
  expect(with(20, -10.0f), {}, "frames_per_second: 24 time_s: 0.1");
  expect(with(20, std::nanf("")), {"time_s"});
  expect(with(24, 1e-30f), {"times must rise"}, "frames_per_second: 24 time_s: 0.1");
  expect(with(32 + 12 * (16 + 2) + 4, std::nanf("")), {"sample 2, point 3: (", "is scale right?"});
  expect(with(32 + 12 * (16 + 2) + 4, 1e30f), {"sample 2, point 3: ("});
  expect(with(32 + 12 * 16, 0.2f),
         {"sample 2 is no shape of this body", "crosses itself", "mend that in the animation"});
  auto turned = growing();
  for (sunder::Vec3& p : turned[1]) p.z() = arch::kHigh - p.z();
  expect(arch::pc2(turned, 0.0f, 12.0f), {"sample 2 turns 'ball' inside out"});
  const std::string path = "path: \"" + files.name(1) + "\" ";
  expect_refusal(deforming(files, "cache { frames_per_second: 24 }"), field + ".path", {"name a PC2 file"});
  expect_refusal(deforming(files, "cache { " + path + "}"), field + ".frames_per_second", {"is missing", "24 or 25"});
  for (const char* rate : {"0", "-24", "nan", "2e6"})
    expect_refusal(deforming(files, "cache { " + path + "frames_per_second: " + rate + " }"),
                   field + ".frames_per_second", {"give more than 0, and at most 1e+06"});
  expect_refusal(deforming(files, "cache { " + path + "frames_per_second: 24 time_s: -1 }"), field + ".time_s",
                 {"give seconds from 0 on"});
  expect_refusal(deforming(files, "inflate { } cache { " + path + "frames_per_second: 24 }"), "bodies[0].deformation",
                 {"both inflate and cache", "give one of them"});
}

}  // namespace
