/// @file
/// Finds the loops of a graph.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/no_index.hpp>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Two nodes that are connected.
using AdfConnection = std::pair<std::size_t, std::size_t>;

/// Divides connections into sets such that two are in one set if a loop passes both. Loops that
/// share no more than a node are apart. Connections of the same two nodes count as one.
class AdfLoops {
 public:
  AdfLoops(std::size_t nodes, const std::vector<AdfConnection>& connections)
      : connections_(connections), neighbours_(nodes), order_(nodes, 0), lowest_(nodes, 0) {
    for (std::size_t i = 0; i < connections.size(); ++i) {
      neighbours_[connections[i].first].push_back(i);
      neighbours_[connections[i].second].push_back(i);
    }
    for (std::size_t root = 0; root < nodes; ++root) {
      if (order_[root] == 0) search(root);
    }
  }

  /// The sets with a loop: numbers of their connections, ascending.
  [[nodiscard]] const std::vector<std::vector<std::size_t>>& sets() const { return sets_; }

 private:
  /// A node on the way from the root, and how far its connections are followed.
  struct Visit {
    std::size_t node;
    std::size_t from;
    std::size_t next = 0;
  };

  [[nodiscard]] std::size_t other_end(std::size_t connection, std::size_t node) const {
    const auto& [a, b] = connections_[connection];
    return a == node ? b : a;
  }

  /// Depth-first search with a stack of its own (Tarjan 1972): a chain may have any length.
  void search(std::size_t root) {
    order_[root] = lowest_[root] = ++met_;
    std::vector<Visit> way{{root, no_index}};
    while (!way.empty()) {
      Visit& here = way.back();
      const std::size_t node = here.node;
      if (here.next == neighbours_[node].size()) {
        const std::size_t from = here.from;
        way.pop_back();
        if (!way.empty()) leave(node, from, way.back().node);
        continue;
      }
      const std::size_t connection = neighbours_[node][here.next++];
      if (connection == here.from) continue;
      const std::size_t other = other_end(connection, node);
      if (order_[other] == 0) {
        order_[other] = lowest_[other] = ++met_;
        open_.push_back(connection);
        way.push_back({other, connection});
      } else if (order_[other] < order_[node]) {
        // Back to a node of the way: a loop, unless it is the node from which this one was met.
        open_.push_back(connection);
        if (way.size() < 2 || other != way[way.size() - 2].node) {
          lowest_[node] = std::min(lowest_[node], order_[other]);
        }
      }
    }
  }

  /// Goes back from a node to the one from which it was met.
  void leave(std::size_t node, std::size_t from, std::size_t parent) {
    lowest_[parent] = std::min(lowest_[parent], lowest_[node]);
    if (lowest_[node] < order_[parent]) return;
    // Nothing from here leads around the parent: the connections since then are a set.
    const auto first = std::find(open_.rbegin(), open_.rend(), from).base() - 1;
    std::vector<std::size_t> set(first, open_.end());
    open_.erase(first, open_.end());
    // Where none leads back to the parent either, they only connect the two.
    if (lowest_[node] > order_[parent]) return;
    std::sort(set.begin(), set.end());
    sets_.push_back(std::move(set));
  }

  const std::vector<AdfConnection>& connections_;
  std::vector<std::vector<std::size_t>> neighbours_;
  std::vector<std::size_t> order_;
  std::vector<std::size_t> lowest_;
  std::size_t met_ = 0;
  // Connections that are in no set yet, in the order of the search.
  std::vector<std::size_t> open_;
  std::vector<std::vector<std::size_t>> sets_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
