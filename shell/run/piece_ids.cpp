#include "shell/run/piece_ids.h"

#include <algorithm>
#include <map>

namespace sunder::shell {

PieceIds::PieceIds(std::vector<std::vector<double>> mass, BodyId first) : mass_(std::move(mass)), next_(first) {
  for (const std::vector<double>& of_shell : mass_) ids_.emplace_back(of_shell.size(), 0);
}

void PieceIds::look(const std::vector<std::vector<int>>& piece) {
  // Pieces are numbered by their first control point here, so that ids do not depend on how the caller numbers them.
  std::map<int, int> order;
  std::map<std::pair<int, BodyId>, double> shares;  // mass of each piece with each of the earlier ids
  auto last = shares.end();
  std::pair<int, int> known{-1, -1};  // neighbouring points are mostly of one piece
  for (std::size_t k = 0; k < piece.size(); ++k)
    for (std::size_t i = 0; i < piece[k].size(); ++i) {
      if (piece[k][i] < 0) continue;
      if (known.first != piece[k][i])
        known = {piece[k][i], order.try_emplace(piece[k][i], static_cast<int>(order.size())).first->second};
      const std::pair<int, BodyId> key{known.second, ids_[k][i]};
      if (last == shares.end() || last->first != key) last = shares.try_emplace(key, 0.0).first;
      last->second += mass_[k][i];
    }
  struct Claim {
    double mass;
    int piece;
    BodyId id;
  };
  std::vector<Claim> claims;
  for (const auto& [key, mass] : shares)
    if (key.second != 0 && taken_.count(key.second) == 0) claims.push_back({mass, key.first, key.second});
  std::stable_sort(claims.begin(), claims.end(), [](const Claim& a, const Claim& b) { return a.mass > b.mass; });
  std::vector<BodyId> id(order.size(), 0);
  std::set<BodyId> given;
  for (const Claim& c : claims)
    if (id[c.piece] == 0 && given.insert(c.id).second) id[c.piece] = c.id;
  for (BodyId& own : id)
    if (own == 0) own = next_++;
  for (std::size_t k = 0; k < piece.size(); ++k)
    for (std::size_t i = 0; i < piece[k].size(); ++i) {
      if (piece[k][i] < 0) continue;
      if (known.first != piece[k][i]) known = {piece[k][i], order.at(piece[k][i])};
      ids_[k][i] = id[known.second];
    }
}

BodyId PieceIds::take(const std::vector<std::pair<std::size_t, int>>& points, const std::set<BodyId>& shared) {
  std::map<BodyId, double> shares;
  for (const auto& [k, i] : points) shares[ids_[k][i]] += mass_[k][i];
  BodyId most = 0;
  for (const auto& [id, mass] : shares)
    if (id != 0 && (taken_.count(id) == 0 || shared.count(id) != 0) && (most == 0 || mass > shares.at(most))) most = id;
  if (most == 0) most = next_++;
  taken_.insert(most);
  return most;
}

}  // namespace sunder::shell
