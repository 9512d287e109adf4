#pragma once
// The engines of this project, by name. No other folder names an engine's classes.
#include <memory>
#include <string>
#include <vector>

#include "coupler/link/engine.h"

namespace sunder::rigid {

using link::ContactRow;
using link::Engine;
using link::EngineInfo;

/// Motion of a body at the end of a window as the shell process predicts it: free flight with gravity and contact with
/// the shell. Contacts and joints between rigid bodies are the engine's part.
using PredictedState = link::Motion;
using EngineState = link::State;

/// Names that make_engine takes.
std::vector<std::string> engine_names();
/// A new engine without bodies. Throws Error (unknown_engine) with the nearest right names.
std::unique_ptr<Engine> make_engine(const std::string& name);

}  // namespace sunder::rigid
