/// @file
/// The YAML of an AMBF description as a tree of bounded size, for any input. Needs yaml-cpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_report.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <yaml-cpp/anchor.h>
#include <yaml-cpp/emitterstyle.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

namespace bristle::inline BRISTLE_ABI::detail {

/// One map, list or scalar. Aliases refer to the node itself, so a tree has no copies.
struct AdfNode {
  enum class Kind { null, scalar, list, map };

  Kind kind = Kind::null;
  std::uint32_t line = 0;
  /// True if an alias names it.
  bool is_aliased = false;
  /// Text of a scalar.
  std::string text;
  /// Items of a list.
  std::vector<std::uint32_t> items;
  /// Entries of a map.
  std::map<std::string, std::uint32_t, std::less<>> entries;
};

/// A document. Node 0 is its root.
struct AdfTree {
  std::string file;
  std::vector<AdfNode> nodes;
  AdfReport report;

  [[noreturn]] void fail(std::size_t line, std::string key, std::string value,
                         std::string rule) const {
    raise(AdfError(file, line, std::move(key), std::move(value), std::move(rule)));
  }
};

/// Builds the tree from the parser's events. The parser descends by recursion, so depth is limited
/// before it does.
class AdfTreeBuilder final : public YAML::EventHandler {
 public:
  /// @param count  [-] Nodes of the documents before it, which count too.
  AdfTreeBuilder(AdfTree& tree, const AdfLimits& limits, std::size_t& count)
      : tree_(tree), limits_(limits), count_(count) {}

  void OnDocumentStart(const YAML::Mark& mark) override { start_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    finish(add(mark, anchor, AdfNode::Kind::null));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    line_ = line_of(mark);
    if (anchor >= anchors_.size() || anchors_[anchor] == no_index) {
      tree_.fail(line_, "", "", "alias of something that is not known");
    }
    const std::uint32_t node = anchors_[anchor];
    for (const Open& open : open_) {
      if (open.node == node) tree_.fail(line_, "", "", "alias within what it names");
    }
    count_nodes(1);
    tree_.nodes[node].is_aliased = true;
    finish(node);
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& value) override {
    const std::uint32_t node = add(mark, anchor, AdfNode::Kind::scalar);
    if (value.size() > max_text) {
      tree_.fail(line_, "", printable(value),
                 "must not be longer than " + std::to_string(max_text) + " bytes");
    }
    tree_.nodes[node].text = value;
    finish(node);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(add(mark, anchor, AdfNode::Kind::list));
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(add(mark, anchor, AdfNode::Kind::map));
  }
  void OnMapEnd() override {
    merge(open_.back().node, open_.back().merged);
    close();
  }

  /// Where the document starts.
  [[nodiscard]] const YAML::Mark& start() const { return start_; }

 private:
  /// [-] Bytes of a scalar. Readers copy names and paths for each block that an alias gives them
  /// to, so one length counts as often as there are blocks.
  static constexpr std::size_t max_text = 1024;

  /// A map or list that has not ended yet.
  struct Open {
    std::uint32_t node = 0;
    bool has_key = false;
    std::string key;
    /// Nodes that `<<` names, in order.
    std::vector<std::uint32_t> merged;
  };

  [[nodiscard]] static std::uint32_t line_of(const YAML::Mark& mark) {
    return mark.line < 0 ? 0u : static_cast<std::uint32_t>(mark.line) + 1u;
  }

  void count_nodes(std::size_t more) {
    count_ += more;
    if (count_ > limits_.max_nodes) {
      tree_.fail(line_, "", "",
                 "more than " + std::to_string(limits_.max_nodes) + " maps, lists and scalars");
    }
  }

  std::uint32_t add(const YAML::Mark& mark, YAML::anchor_t anchor, AdfNode::Kind kind) {
    line_ = line_of(mark);
    count_nodes(1);
    const auto node = static_cast<std::uint32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    tree_.nodes.back().kind = kind;
    tree_.nodes.back().line = line_;
    if (anchor != YAML::NullAnchor) {
      if (anchor >= anchors_.size()) anchors_.resize(anchor + 1, no_index);
      anchors_[anchor] = node;
    }
    return node;
  }

  void open(std::uint32_t node) {
    if (open_.size() == limits_.max_depth) {
      tree_.fail(line_, "", "",
                 "more than " + std::to_string(limits_.max_depth) +
                     " levels of maps and lists in each other");
    }
    open_.emplace_back();
    open_.back().node = node;
  }
  void close() {
    const std::uint32_t node = open_.back().node;
    open_.pop_back();
    finish(node);
  }

  /// Adds a finished node to the map or list around it.
  void finish(std::uint32_t number) {
    if (open_.empty()) return;
    Open& parent = open_.back();
    AdfNode& around = tree_.nodes[parent.node];
    if (around.kind == AdfNode::Kind::list) {
      around.items.push_back(number);
    } else if (!parent.has_key) {
      const AdfNode& node = tree_.nodes[number];
      if (node.kind != AdfNode::Kind::scalar && node.kind != AdfNode::Kind::null) {
        tree_.fail(node.line, "", "", "a key must be a scalar");
      }
      parent.key = node.text;
      parent.has_key = true;
    } else {
      parent.has_key = false;
      if (parent.key == "<<") {
        parent.merged.push_back(number);
      } else if (!around.entries.emplace(parent.key, number).second) {
        tree_.report.add(AdfNoteKind::changed, printable(parent.key),
                         "given twice in one map: the first counts", line_);
      }
    }
  }

  /// Copies the keys of other maps that a map lacks. The first source with a key wins. Sources are
  /// merged already, since an alias follows its anchor.
  void merge(std::uint32_t into, const std::vector<std::uint32_t>& sources) {
    for (const std::uint32_t source : sources) {
      if (tree_.nodes[source].kind == AdfNode::Kind::list) {
        for (const std::uint32_t item : tree_.nodes[source].items) merge_one(into, item);
      } else {
        merge_one(into, source);
      }
    }
  }
  void merge_one(std::uint32_t into, std::uint32_t source) {
    const AdfNode& from = tree_.nodes[source];
    if (from.kind != AdfNode::Kind::map) tree_.fail(from.line, "<<", "", "must name maps");
    count_nodes(from.entries.size());
    tree_.nodes[into].entries.insert(from.entries.begin(), from.entries.end());
  }

  AdfTree& tree_;
  const AdfLimits& limits_;
  std::vector<Open> open_;
  std::vector<std::uint32_t> anchors_;
  std::size_t& count_;
  std::uint32_t line_ = 0;
  YAML::Mark start_ = YAML::Mark::null_mark();
};

/// Parses the documents of a text. Those without content are left out.
/// @throws AdfError that names the line, if the text is no YAML, is empty or exceeds a limit.
[[nodiscard]] inline std::vector<AdfTree> read_adf_trees(std::string_view text,
                                                         std::string_view file,
                                                         const AdfLimits& limits) {
  std::vector<AdfTree> trees;
  const auto fail = [&](std::size_t line, std::string rule) {
    raise(AdfError(std::string(file), line, "", "", std::move(rule)));
  };
  if (text.size() > limits.max_bytes) {
    fail(0, "larger than " + std::to_string(limits.max_bytes) + " bytes");
  }
  std::istringstream stream{std::string(text)};
  try {
    YAML::Parser parser(stream);
    std::size_t count = 0;
    int last_start = -1;
    while (true) {
      AdfTree tree;
      tree.file = file;
      tree.report = AdfReport(tree.file);
      AdfTreeBuilder builder(tree, limits, count);
      if (!parser.HandleNextDocument(builder)) break;
      // The parser leaves a bracket that closes nothing where it is, and would meet it for ever.
      if (builder.start().pos <= last_start) {
        fail(static_cast<std::size_t>(builder.start().line) + 1, "no YAML: no document");
      }
      last_start = builder.start().pos;
      if (tree.nodes.empty() || tree.nodes[0].kind == AdfNode::Kind::null) continue;
      trees.push_back(std::move(tree));
    }
  } catch (const YAML::Exception& error) {
    fail(error.mark.is_null() ? 0 : static_cast<std::size_t>(std::max(error.mark.line, 0)) + 1,
         "no YAML: " + printable(error.msg, error.msg.size()));
  }
  if (trees.empty()) fail(0, "file is empty");
  return trees;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
