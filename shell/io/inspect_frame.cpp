#include "shell/io/inspect_frame.h"

#include "shell/io/frames.h"

namespace sunder::shell {

void write_frame_of(const RunSetup& setup, const std::string& folder) {
  std::vector<ShellState> states;
  states.reserve(setup.shells.size());
  for (const ShellSetup& s : setup.shells) states.push_back(make_state(s.model, Vec3::Zero(), 0));
  std::vector<ShellView> views;
  std::vector<std::vector<BodyId>> pieces;
  for (std::size_t k = 0; k < states.size(); ++k) {
    views.push_back({&setup.shells[k].model, &states[k]});
    pieces.emplace_back(setup.shells[k].model.control_points(), static_cast<BodyId>(k + 1));
  }
  FrameWriter(folder).write(0.0, views, pieces, {}, {}, 1);
}

}  // namespace sunder::shell
