// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/rigid/catalogue.hpp"

#include "scenes/rigid/chains.hpp"
#include "scenes/rigid/driven.hpp"
#include "scenes/rigid/drops.hpp"
#include "scenes/rigid/flight.hpp"
#include "scenes/rigid/grips.hpp"
#include "scenes/rigid/hands.hpp"
#include "scenes/rigid/heaps.hpp"
#include "scenes/rigid/linked.hpp"
#include "scenes/rigid/published.hpp"
#include "scenes/rigid/sliding.hpp"
#include "scenes/rigid/stacks.hpp"
#include "scenes/rigid/swings.hpp"
#include "scenes/rigid/tumbling.hpp"
#include "scenes/rigid/unseen_driven.hpp"
#include "scenes/rigid/unseen_motion.hpp"
#include "scenes/rigid/unseen_rest.hpp"

#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace bristle::scenes {

namespace {

/// Collects recipes of a group.
class RecipeBook {
 public:
  void open(std::string group, std::vector<double> time_steps) {
    group_ = std::move(group);
    time_steps_ = std::move(time_steps);
  }
  /// A scene that is one trial, made from copies of the arguments.
  template <typename T, typename... Arguments>
  Recipe& add(std::string name, std::string description, Arguments... arguments) {
    Recipe& recipe = add_empty(std::move(name), std::move(description));
    recipe.make_one = [... args = std::move(arguments)] { return std::make_unique<T>(args...); };
    return recipe;
  }
  /// A scene of several trials that differ in a number.
  Recipe& add_varied(std::string name, std::string description, int variations,
                     std::function<std::unique_ptr<Trial>(int)> make) {
    Recipe& recipe = add_empty(std::move(name), std::move(description));
    recipe.variations = variations;
    recipe.make_variation = std::move(make);
    return recipe;
  }
  [[nodiscard]] std::vector<Recipe> take() { return std::move(recipes_); }

 private:
  Recipe& add_empty(std::string name, std::string description) {
    recipes_.push_back({group_, std::move(name), std::move(description), time_steps_});
    return recipes_.back();
  }

  std::string group_;
  std::vector<double> time_steps_;
  std::vector<Recipe> recipes_;
};

void add_matrix(RecipeBook& book) {
  constexpr double degree = std::numbers::pi / 180;
  book.open("matrix", {1.0 / 60, 1.0 / 240, 1.0 / 1000});
  book.add<Slide>("slide", "box slides to rest, stopping distance [m]", 0.0);
  book.add<Slide>("slide30", "the same, 30 degrees off the axes [m]", 30 * degree);
  book.add<Incline>("incline_stick", "box at 0.9 of the friction angle, creep [m/s]", 0.9);
  book.add<Incline>("incline_slip", "box at 1.1 of the friction angle, acceleration [1]", 1.1);
  book.add<Roll>("roll", "sliding ball comes to roll, speed [m/s]");
  book.add<Bounce>("bounce08", "ball bounces, e = 0.8, peak heights [1]", 0.8);
  book.add<Bounce>("bounce10", "ball bounces, e = 1, peak heights [1]", 1.0);
  book.add<Spin>("spin", "free tumbling, energy [1]");
  book.add<Chain>("chain2", "swinging chain of 2 links, energy [1]", 2);
  book.add<Chain>("chain10", "swinging chain of 10 links, energy [1]", 10);
  book.add<Stack>("stack10", "stack of 10 cubes, drift or depth [m]", StackSetup{});
  book.add<Stack>("stack1000", "4 cubes, 1000 times the mass on top, drift or depth [m]",
                  StackSetup{.count = 4, .top_mass = 1000});
  book.add<Grip>("grip", "two fingers hold a cube at 41 % load, displacement [m]", GripSetup{});
  book.add<Grip>("grip15", "the same, cube turned by 15 degrees [m]",
                 GripSetup{.angle = 15 * degree});
  book.add<Grip>("grip90pct", "the same at 90 % load [m]", GripSetup{.mass = 1.1});
  book.add<Grip>("gripoff", "cube turned by 15 degrees and 10 mm off centre [m]",
                 GripSetup{.angle = 15 * degree, .offset = 0.01});
}

void add_loads(RecipeBook& book) {
  book.open("load", {1.0 / 60, 1.0 / 240, 1.0 / 1000});
  for (const int percent : {50, 60, 70, 80, 90, 95, 99}) {
    book.add<Grip>("gripload" + std::to_string(percent),
                   "grip at " + std::to_string(percent) + " % load, displacement [m]",
                   GripSetup{.mass = grip_mass(percent / 100.0)});
  }
}

void add_heaps(RecipeBook& book) {
  book.open("heap", {1.0 / 60, 1.0 / 240});
  book.add<StandingHeap>("pyramid20", "210 boxes, deepest overlap at the end [m]", pyramid());
  book.add<StandingHeap>("planks30", "tower of 120 planks, deepest overlap at the end [m]",
                         tower_of_planks());
  book.add<Pile>("pile200", "200 boxes and balls in a bin, deepest overlap at the end [m]", 200);
  book.add<Pile>("pile1000", "1000 of them [m]", 1000);
}

void add_flights(RecipeBook& book) {
  book.open("flight", {1.0 / 60, 1.0 / 240, 1.0 / 1000});
  book.add<Flight>("flight1000", "1000 balls fly, distance from the parabola [m]");
}

void add_drops(RecipeBook& book) {
  book.open("drop", {1.0 / 60, 1.0 / 120, 1.0 / 240, 1.0 / 500, 1e-3, 5e-4, 1e-4});
  const auto add = [&book](const char* name, const char* description, int splits) {
    book.add_varied(name, description, Drop::phases,
                    [splits](int phase) { return std::make_unique<Drop>(splits, phase); });
  };
  add("drop_sphere", "50 kg ball falls 2 m, worst depth of 8 phases [m]", -1);
  add("drop_hull80", "the same, hull of 80 triangles [m]", 1);
  add("drop_hull1280", "the same, hull of 1280 triangles [m]", 3);
}

void add_published(RecipeBook& book) {
  book.open("published", {1e-2, 1e-3});
  book.add<PulledPlate>("sb_roll_y", "25 balls on a pulled plate, squared velocity [m^2/s^2]",
                        false);
  book.add<PulledPlate>("sb_roll_xy", "the same, pulled obliquely [m^2/s^2]", true);
  book.add<EnergyKept>("sb_bounce", "49 elastic balls, squared change of energy [J^2]",
                       bouncing_balls(), 0.05, true);
  book.add<CollapsingCube>("sb_666", "216 balls collapse, squared depths [m^2]");
  book.add<EnergyKept>("sb_e666", "216 elastic balls, squared change of energy [J^2]",
                       cube_of_balls(true), 0.05, false);
}

void add_perturbed(RecipeBook& book) {
  constexpr int seeds = 20;
  book.open("perturbed", {1.0 / 60, 1.0 / 240, 1.0 / 1000});
  const auto add_stack = [&book](const char* name, const char* description, StackSetup setup) {
    setup.offset = 0.01;
    setup.yaw = 0.2;
    setup.gap = 0.001;
    book.add_varied(name, description, seeds, [setup](int seed) {
      StackSetup own = setup;
      own.seed = static_cast<std::uint64_t>(seed) + 1;
      return std::make_unique<Stack>(own);
    });
  };
  add_stack("stackp", "10 cubes land askew, drift or depth, worst of 20 seeds [m]", {});
  add_stack("stackp1000", "4 cubes, 1000 times the mass on top, the same [m]",
            {.count = 4, .top_mass = 1000});
  const auto add_grip = [&book](const char* name, const char* description, double load) {
    book.add_varied(name, description, seeds, [load](int seed) {
      return std::make_unique<Grip>(pulsed_grip(load, static_cast<std::uint64_t>(seed) + 1));
    });
  };
  add_grip("gripp60", "pulsing grip at 60 % of its least capacity, displacement [m]", 0.60);
  add_grip("gripp85", "pulsing grip at 85 % [m]", 0.85);
  book.add<ContactChain>("contact_chain", "5 links swing against a plate, joint gap or depth [m]");
}

void add_moving(RecipeBook& book) {
  book.open("moving", {1.0 / 60, 1.0 / 240, 1.0 / 1000});
  book.add<Watched>("push24", "24 cubes pushed by a plate, overlap [m]", pushed_boxes(4),
                    Bounds{.depth = 5e-3});
  book.add<Watched>("push48", "48 cubes pushed by a plate, overlap [m]", pushed_boxes(8),
                    Bounds{.depth = 5e-3});
  book.add<Watched>("push120", "120 cubes pushed by a plate, overlap [m]", pushed_boxes(20),
                    Bounds{.depth = 5e-3});
  book.add<Watched>("belt48", "48 cubes held back on a moving belt, overlap [m]",
                    held_back_on_belt(), Bounds{.depth = 5e-3});
  book.add<DraggedStack>("dragged", "8 boxes on a plate that is dragged, displacement [m]");
  book.add<Watched>("chain100", "chain of 100 over a cylinder, joint gap or overlap [m]",
                    chain_over_cylinder(), Bounds{.depth = 5e-3, .gain = 1});
  book.add<Watched>("ragdolls20", "20 ragdolls fall, joint gap or overlap [m]", falling_ragdolls(),
                    Bounds{.depth = 0.02, .gain = 100});
  book.add<HeldInHand>("hand", "hand of 12 drives holds a part and is shaken, displacement [m]",
                       HandSetup{});
  book.add<HeldInHand>("hand128", "the same with 128 sensors and weaker drives [m]",
                       HandSetup{.has_sensors = true, .max_torque = 1.5});
  book.add<Watched>("bricks20", "ball of 50 bricks' mass hits a wall of 20, overlap [m]",
                    knocked_down_wall(), Bounds{.depth = 0.02, .gain = 35});
  book.add<Watched>("bin64", "64 mixed bodies in a bin, overlap [m]", mixed_bin(),
                    Bounds{.depth = 0.01});
  book.add<Bowl>("bowl300", "300 bodies in a bowl of triangles, overlap or escape [m]", false);
  book.add<Bowl>("rings300", "the same, one in eight a ring of triangles [m]", true);
  book.add<Watched>("drum60", "60 mixed bodies in a turning drum, overlap [m]", drum(),
                    Bounds{.depth = 0.01});
  book.add<PinchedPlate>("pinched", "plate swings between two fingertips, amplitude [1]");
  book.add<TopplingRow>("topple20", "20 dominoes fall, interval against fine steps [1]")
      .reference_step = 1.0 / 8000;
  book.add<Pendulum>("pendulum", "pendulum on a hinge, energy [1]", Inert::nothing);
  book.add<Pendulum>("pendulum_motor", "the same with a motor without torque [1]", Inert::motor);
  book.add<Pendulum>("pendulum_sensor", "the same with sensors without force [1]", Inert::sensors);
}

void add_unseen(RecipeBook& book) {
  book.open("unseen", {1.0 / 60, 1.0 / 240, 1.0 / 1000});
  book.add<GrooveRoll>("groove", "ball rolls down a V groove, distance [1]");
  book.add<Rollers>("rollers", "plank rolls down on four balls, distance [1]");
  book.add<Tug>("tug", "box pulled by a growing force, distance [1]");
  book.add<Coin>("coin", "coin rolls on its edge, energy [1]");
  book.add<Cradle>("cradle", "ball hits four that touch, energy or momentum [1]");
  book.add<Dominoes>("dominoes", "row of ten falls: energy gain, standing, depth [1]");
  book.add<StaysPut>("overhang", "four overhanging planks, displacement [m]", overhanging_planks());
  book.add<StaysPut>("lintel", "loaded beam on pillars, displacement [m]", loaded_lintel());
  book.add<StaysPut>("wedge", "cube between two inclines, displacement [m]", wedged_cube());
  book.add<Toss>("toss", "24 blocks tossed into a bin, deepest overlap at the end [m]");
  book.add<Turntable>("turntable", "ball on a turning table, distance from its circle [m]");
  book.add<Shaker>("shaker", "box sticks and slides on a shaken table, distance [m]");
  book.add<Servo>("servo", "arm driven to an angle, difference from the closed form [rad]");
}

void add_long(RecipeBook& book) {
  book.open("long", {1e-3});
  Recipe& rest = book.add<Stack>("stack10_long", "stack of 10 for 1e6 steps, drift or depth [m]",
                                 StackSetup{.duration = 1000});
  rest.is_optional = true;
}

}  // namespace

std::vector<Recipe> catalogue() {
  RecipeBook book;
  add_matrix(book);
  add_loads(book);
  add_heaps(book);
  add_flights(book);
  add_drops(book);
  add_published(book);
  add_perturbed(book);
  add_moving(book);
  add_unseen(book);
  add_long(book);
  return book.take();
}

}  // namespace bristle::scenes
