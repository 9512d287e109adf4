#pragma once
// What reads bytes that others wrote. A target takes any bytes; what it must not do ends the process.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace sunder::fuzz {

struct Target {
  const char* name;
  void (*run)(const std::uint8_t* data, std::size_t size);
  /// Bytes in, mutated bytes out, at most `most` of them: a message should mostly stay one. None: bytes only.
  std::string (*mutate)(const std::string& bytes, std::size_t most, unsigned seed);
};

const std::vector<Target>& targets();

/// Ends the process, with the reason, unless `good`: a finding.
void demand(bool good, const std::string& what);
/// Runs `work`; ends the process where it throws anything but an Error of bad input with a kind.
void refuses_by_name(const std::function<void()>& work);
/// A file of this process that holds `bytes`, in TMPDIR, removed as the process ends.
std::string file_with(const std::string& name, const std::uint8_t* data, std::size_t size);

void run_session(const std::uint8_t* data, std::size_t size);
void run_bullet(const std::uint8_t* data, std::size_t size);
void run_ode(const std::uint8_t* data, std::size_t size);
void run_replies(const std::uint8_t* data, std::size_t size);
void run_scene(const std::uint8_t* data, std::size_t size);
void run_pgm(const std::uint8_t* data, std::size_t size);
void run_mesh(const std::uint8_t* data, std::size_t size);
void run_surface(const std::uint8_t* data, std::size_t size);
void run_pc2(const std::uint8_t* data, std::size_t size);
void run_cad(const std::uint8_t* data, std::size_t size);
std::string mutate_session(const std::string& bytes, std::size_t most, unsigned seed);
std::string mutate_reply(const std::string& bytes, std::size_t most, unsigned seed);
/// Of a file: bits, numbers in digits and in bytes, stretches that are missing, twice there or exchanged. The first
/// byte, which says how the file is read, stays.
std::string mutate_file(const std::string& bytes, std::size_t most, unsigned seed);

}  // namespace sunder::fuzz
