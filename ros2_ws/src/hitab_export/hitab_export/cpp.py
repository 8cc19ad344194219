"""The export of a behavior to one C++17 header that needs only the standard library."""

from __future__ import annotations

import json
import math

from hitab_export.hierarchy_form import Hierarchy, LeafForm
from hitab_export.names import identifiers

_KEYWORDS = """
alignas alignof and asm auto bitand bitor bool break case catch char class compl concept const
constexpr continue decltype default delete do double else enum explicit export extern false float
for friend goto if inline int long mutable namespace new noexcept not nullptr operator or private
protected public register requires return short signed sizeof static struct switch template this
throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor
INFINITY NAN Features
"""

CPP_HEADER = """\
//
//     {space}::Behavior robot;
//     {space}::Features features;  // all missing (NaN) until they are set
//     auto action = robot.tick(features, seconds, draw);  // once per cycle
//
// `draw` returns a random number from [0, 1). Booleans are 0 or 1, a category is its index.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \\
    defined(_M_FP_FAST)
#error "A missing value is NaN, which -ffast-math treats as a number: add -fno-finite-math-only"
#endif

namespace {space} {{

struct Features {{{members}
}};
"""

TYPES = """
/// A basic behavior to perform. `started`: it begins now; stop the one before, even if it has the
/// same name. If it is `one_shot`, perform it only then.
struct Action {
  std::string name;
  std::vector<std::string> arguments;
  bool one_shot, started;
};

struct Feature {
  double Features::*value;
  const char* name;
  int categories;  // -1: on a circle
  bool required;
};

/// low < value <= high; a leaf has feature -1, and its chances are from yes to no.
struct Node {
  int feature;
  double period, low, high;
  int yes, no;
  double share;
};

struct Chance {
  double below;
  int state;
};

/// -1: performs no automaton, no basic behavior; has no tree.
struct State {
  const char* label;
  int automaton, basic, tree;
};
"""

RUNTIME = """
class Behavior {
 public:
  /// Begin anew; the first tick does so by itself.
  void start(double now) { levels_ = {Level(int(AUTOMATA.size()) - 1, now)}; }

  /// Return the basic behavior to perform; none: stop the one before, and do nothing.
  /// Throws std::invalid_argument if a value is impossible, or missing but required.
  std::optional<Action> tick(const Features& features, double now,
                             const std::function<double()>& draw) {
    if (levels_.empty()) start(now);
    for (std::size_t depth = 0;; ++depth) {
      Level& level = levels_[depth];
      for (int required : REQUIRED[level.automaton]) read(FEATURES[required], features);
      const std::vector<State>& states = AUTOMATA[level.automaton];
      const State& before = states[level.state];
      if (before.automaton < 0 && before.basic < 0) level.state = 0;  // Start, flags: left at once
      double own[5] = {0, 0, level.state ? std::max(0.0, now - level.entered) : 0, 0, 0};
      for (int flag : {0, 1}) {
        if (depth + 1 < levels_.size() && levels_[depth + 1].raised[flag]) {
          own[flag] = 1;
          level.seen[flag] = now;
          levels_[depth + 1].raised[flag] = false;
        }
        own[3 + flag] = std::max(0.0, now - level.seen[flag]);
      }
      const int tree = states[level.state].tree;
      const int chosen = tree < 0 ? level.state : decide(tree, own, features, draw);
      const bool started = chosen != level.state;
      const State& state = states[chosen];
      if (started) {
        level.state = chosen;
        level.entered = now;
        if (state.automaton < 0 && state.basic < 0) level.raised[state.label[0] == 'F'] = true;
        levels_.erase(levels_.begin() + depth + 1, levels_.end());
        if (state.automaton >= 0) levels_.emplace_back(state.automaton, now);
      }
      if (state.automaton >= 0) continue;
      if (state.basic < 0) return std::nullopt;
      Action action = BASICS[state.basic];
      action.started = started;
      return action;
    }
  }

  /// The active states, the outermost first.
  std::vector<std::string> path() const {
    std::vector<std::string> found;
    for (const Level& level : levels_)
      found.push_back(AUTOMATA[level.automaton][level.state].label);
    return found;
  }

  /// Whether the behavior has raised Done or Failed since it was last asked.
  bool done() { return !levels_.empty() && std::exchange(levels_[0].raised[0], false); }
  bool failed() { return !levels_.empty() && std::exchange(levels_[0].raised[1], false); }

 private:
  struct Level {
    Level(int automaton, double now) : automaton(automaton), entered(now), seen{now, now} {}
    int automaton, state = 0;
    double entered, seen[2];
    bool raised[2] = {false, false};
  };

  static double read(const Feature& feature, const Features& features) {
    const double value = features.*feature.value;
    const int categories = feature.categories;
    if (std::isnan(value) ? feature.required
        : categories < 0
            ? std::isinf(value)
            : categories > 0 && !(0 <= value && value < categories && value == std::floor(value)))
      throw std::invalid_argument(std::string(feature.name) + " has an impossible value or none");
    return value;
  }

  static int decide(int tree, const double* own, const Features& features,
                    const std::function<double()>& draw) {
    const Node* node = &NODES[tree];
    double drawn = -1;
    const double largest = std::nextafter(1.0, 0.0);
    while (node->feature >= 0) {
      const int f = node->feature;
      double value = f < 5 ? own[f] : read(FEATURES[f - 5], features);
      if (node->period != 0) {
        value = std::fmod(value, node->period);
        if (value < 0) value += node->period;
      }
      bool yes = node->low < value && value <= node->high;
      if (std::isnan(value)) {  // It is missing: draw, as often as examples went there.
        if (drawn < 0) drawn = draw();
        yes = drawn < node->share;
        drawn = yes ? drawn / node->share
                    : std::min((drawn - node->share) / (1 - node->share), largest);
      }
      node = &NODES[yes ? node->yes : node->no];
    }
    const Chance* chance = &CHANCES[node->yes];
    if (node->no - node->yes == 1) return chance->state;
    if (drawn < 0) drawn = draw();
    while (drawn >= chance->below) ++chance;
    return chance->state;
  }

  std::vector<Level> levels_;
};
"""


def as_cpp(hierarchy: Hierarchy, origin: str) -> str:
    """Return the header's text; ``origin`` describes where the behavior comes from."""
    names = identifiers((feature.label for feature in hierarchy.features), _KEYWORDS.split())
    top = str(hierarchy.top.term)
    space = f"hitab_{identifiers([top])[top]}"
    members = "".join(
        f"\n  double {names[feature.label]} = NAN;  // {feature.label}"
        + (f", {feature.unit}" if feature.unit else "")
        for feature in hierarchy.features
    )
    features = [
        f"&Features::{names[feature.label]}, {json.dumps(feature.label)}, {feature.categories}, "
        f"{json.dumps(feature.required)}"
        for feature in hierarchy.features
    ]
    basics = [
        f"{json.dumps(term.name)}, {{{', '.join(map(json.dumps, term.arguments))}}}, "
        f"{json.dumps(one_shot)}, false"
        for term, one_shot in hierarchy.basics.items()
    ]
    automata, nodes, chances = _tables(hierarchy)
    required = [automaton.required for automaton in hierarchy.automata]
    parts = [
        "\n".join(f"// {line}".rstrip() for line in origin.splitlines()),
        "\n" + CPP_HEADER.format(space=space, members=members),
        TYPES,
        _table("Feature", "FEATURES", features),
        _table("Action", "BASICS", basics),
        _table("Node", "NODES", nodes),
        _table("Chance", "CHANCES", chances),
        _table("std::vector<State>", "AUTOMATA", automata),
        _table("std::vector<int>", "REQUIRED", [", ".join(map(str, r)) for r in required]),
        RUNTIME,
        f"\n}}  // namespace {space}\n",
    ]
    return "".join(parts)


def _table(kind: str, name: str, rows: list[str]) -> str:
    inner = "".join(f"    {{{row}}},\n" for row in rows)
    return f"\ninline const std::vector<{kind}> {name} = {{\n{inner}}};\n"


def _tables(hierarchy: Hierarchy) -> tuple[list[str], list[str], list[str]]:
    """Return the rows of AUTOMATA, NODES and CHANCES."""
    automata: list[str] = []
    nodes: list[str] = []
    chances: list[str] = []
    numbers = {automaton.term: i for i, automaton in enumerate(hierarchy.automata)}
    basics = {term: i for i, term in enumerate(hierarchy.basics)}
    for automaton in hierarchy.automata:
        rows = []
        for state in automaton.states:
            performs, first = state.performs, len(nodes)
            made_of = numbers[performs] if performs is not None and state.is_automaton else -1
            basic = basics[performs] if performs is not None and not state.is_automaton else -1
            root = -1 if state.tree is None else first
            rows.append(f"{{{json.dumps(state.label)}, {made_of}, {basic}, {root}}}")
            for node in state.tree or ():
                if isinstance(node, LeafForm):
                    end = len(chances) + len(node.chances)
                    nodes.append(f"-1, 0, 0, 0, {len(chances)}, {end}, 0")
                    chances += [f"{below!r}, {to}" for below, to in node.chances]
                else:
                    low, high = map(_number, (node.low, node.high))
                    yes, no = node.yes + first, node.no + first
                    limits = f"{node.period!r}, {low}, {high}"
                    nodes.append(f"{node.feature}, {limits}, {yes}, {no}, {node.share!r}")
        automata.append(f"  // {automaton.term}\n     " + ",\n     ".join(rows))
    return automata, nodes, chances


def _number(value: float) -> str:
    return repr(value) if math.isfinite(value) else f"{'-' if value < 0 else ''}INFINITY"
