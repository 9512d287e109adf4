#pragma once
// The keys of an encrypted session: a folder with a pair for each side, one key a file, as 40 characters of Z85.
#include <string>

namespace sunder::link {

enum class Side { kRigid, kShell };

/// What one side needs of the folder; 32 bytes each.
struct Keys {
  std::string secret, own_public, peer_public;
};

/// Makes a folder of mode 0700 with rigid.key and shell.key (secret, 0600), rigid.pub and shell.pub. An empty folder
/// that is there already is taken. Throws Error (bad_keys) where there is something in it or it cannot be written;
/// nothing is ever written over, and of what was begun nothing stays.
void make_keys(const std::string& folder);

/// Reads this side's secret and both public keys; the other side's secret need not be there. Throws Error (bad_keys),
/// with file, problem and remedy: a file is missing or damaged, others may read the secret or replace a key, or the
/// secret and the public key are no pair.
Keys read_keys(const std::string& folder, Side side);

}  // namespace sunder::link
