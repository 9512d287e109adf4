#pragma once
// Keys of an encrypted session: a folder with a key pair for each side. A file holds one key in 40 characters of Z85.
#include <string>

namespace sunder::link {

enum class Side { kRigid, kShell };

/// The keys that one side needs, 32 bytes each.
struct Keys {
  std::string secret, own_public, peer_public;
};

/// Makes a folder of mode 0700 with rigid.key and shell.key (secret, mode 0600), rigid.pub and shell.pub. An empty
/// folder may exist already. Throws Error (bad_keys) where the folder is not empty or cannot be written. No file is
/// ever overwritten, and a failed call leaves no file.
void make_keys(const std::string& folder);

/// Reads this side's secret key and both public keys. The other side's secret key may be absent. Throws Error
/// (bad_keys) with file, problem and remedy. It does so for a missing or damaged file, and for keys that are no pair.
/// It also does so where other users may read the secret or replace a key.
Keys read_keys(const std::string& folder, Side side);

}  // namespace sunder::link
