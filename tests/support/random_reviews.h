#pragma once

#include <random>
#include <string>

#include "render/picture/tonemap.h"
#include "review/review.h"

namespace maquette::test {

/// Random changes of everything that a review holds.
class RandomReviews {
 public:
  explicit RandomReviews(unsigned seed) : random_(seed) {}

  void change(Review* review) {
    switch (pick(7)) {
      case 0:
        return change_list(&review->looks, [&] {
          Look look = review->look;
          for (int i = 0; i < 3; ++i) change(&look);
          look.name = free_name(review->looks, "look " + std::to_string(pick(20)));
          return look;
        });
      case 1:
        return change_list(&review->paths, [&] {
          CameraPath path = random_path();
          path.name = "path " + std::to_string(number_++);
          return path;
        });
      case 2:
        return change_list(&review->regions, [&] {
          const float x = real(0.0f, 0.9f), y = real(0.0f, 0.9f);
          return InspectedRegion{x, y, real(0.0f, 1.0f - x), real(0.0f, 1.0f - y)};
        });
      case 3:
        return change(&review->inspection);
      default:
        return change(&review->look);
    }
  }
  void change(InspectionSetup* setup) {
    switch (pick(8)) {
      case 0:
        setup->background_given = pick(2) == 0;
        setup->background_cdm2 = std::exp(real(-3.0f, 9.0f));
        break;
      case 1:
        setup->eye_box_mm = {real(0.0f, 500.0f), real(0.0f, 500.0f)};
        setup->grid = {1 + pick(kMostGrid), 1 + pick(kMostGrid)};
        break;
      case 2:
        setup->threshold_cdm2 = real(1.0f, 1e4f);
        setup->polarisation = pick(4);
        break;
      case 3:
        setup->low_cdm2 = real(0.1f, 10.0f);
        setup->high_cdm2 = real(20.0f, 1e6f);
        setup->in_ev = pick(2) == 0;
        break;
      case 4:
        setup->r_point_m = {real(-2.0f, 2.0f), real(-2.0f, 2.0f), real(-2.0f, 2.0f)};
        setup->eye_mm = {real(-99.0f, 99.0f), real(-99.0f, 99.0f), real(500.0f, 700.0f)};
        setup->which_eye = pick(3);
        break;
      case 5:
        setup->light = static_cast<InspectionSetup::Light>(pick(3));
        setup->lux_on_glass = real(1.0f, 1e5f);
        break;
      case 6:
        setup->dash_given = pick(2) == 0;
        setup->dash_reflectance = real(0.0f, 1.0f);
        setup->both_eyes = pick(2) == 0;
        setup->right_hand_drive = pick(2) == 0;
        break;
      default:
        setup->sweep = pick(static_cast<int>(sweep_names().size()));
        setup->sweep_range = {real(0.0f, 9.0f), real(10.0f, 90.0f)};
        setup->sweep_count = 2 + pick(20);
    }
  }
  void change(Look* look) {
    Edits& edits = look->edits;
    switch (pick(18)) {
      case 0:
        edits.environment = "/a place/" + word() + ".hdr";
        break;
      case 1:
        edits.env_rotation_deg = real(-180.0f, 180.0f);
        break;
      case 2:
        edits.env_scale = std::exp(real(-3.0f, 9.0f));
        break;
      case 3:
        edits.variant = word();
        break;
      case 4:
        if (edits.materials.size() > 3) edits.materials.erase(edits.materials.begin());
        edits.materials[word()] = "builtin:" + word();
        break;
      case 5:
        if (edits.dents.size() > 3) edits.dents.erase(edits.dents.begin() + pick(3));
        edits.dents.push_back({point(), real(-0.1f, 0.1f), real(0.01f, 2.0f), pick(2) ? "/car/" + word() : ""});
        break;
      case 6:
        if (!edits.hidden_nodes.insert("/" + word()).second) edits.hidden_nodes.clear();
        break;
      case 16:
        edits.animation = pick(3) ? PlayedAnimation{word(), static_cast<double>(pick(1000)) / 64.0} : PlayedAnimation();
        break;
      case 17:
        edits.turns.push_back({"/" + word(), glm::vec3(0.0f, 0.6f, -0.8f), real(-180.0f, 180.0f)});
        if (edits.turns.size() > 3) edits.turns.clear();
        break;
      case 15:
        edits.section = pick(3) ? glm::vec4(glm::normalize(point() + glm::vec3(0.0f, 0.0f, 200.0f)), real(-2.0f, 2.0f))
                                : glm::vec4(0.0f);
        break;
      case 7:
        if (!edits.reflectors.insert("/" + word() + "#2").second) edits.reflectors.clear();
        break;
      case 8:
        edits.part_modes["/" + word()] = any_of(builtin_registry().names(TechniqueKind::mode));
        break;
      case 9:
        look->mode = any_of(builtin_registry().names(TechniqueKind::mode));
        break;
      case 10:
        look->reflections = any_of(builtin_registry().names(TechniqueKind::reflector));
        break;
      case 11:
        change(&look->settings);
        break;
      case 12:
        look->auto_exposure = pick(2) == 0;
        look->exposure_ev = look->auto_exposure ? 0.0f : real(-20.0f, 20.0f);
        break;
      case 13:
        look->tonemap = any_of(tonemap_names());
        look->note = word() + " \"quoted\" \xc3\xa9\n" + word();
        break;
      default:
        look->camera = camera();
    }
  }
  void change(Settings* settings) {
    const SettingDeclaration& declaration =
        setting_declarations()[static_cast<std::size_t>(pick(static_cast<int>(setting_declarations().size())))];
    const double low = declaration.min, high = declaration.min == declaration.max ? low + 10.0 : declaration.max;
    const double value = low + (high - low) * static_cast<double>(real(0.0f, 1.0f));
    if (std::holds_alternative<bool>(declaration.default_value))
      settings->set(declaration.name, pick(2) == 0);
    else if (std::holds_alternative<int>(declaration.default_value))
      settings->set(declaration.name, static_cast<int>(value));
    else if (std::holds_alternative<double>(declaration.default_value))
      settings->set(declaration.name, value);
    else
      settings->set(declaration.name, declaration.choices.empty() ? word() : any_of(declaration.choices));
  }
  CameraView camera() {
    CameraView view;
    view.eye = point();
    view.target = view.eye + glm::vec3(real(0.1f, 1.0f), real(-1.0f, 1.0f), real(-1.0f, 1.0f));
    view.up = {real(-0.2f, 0.2f), 1.0f, real(-0.2f, 0.2f)};
    view.fov_y_rad = real(0.1f, 2.0f);
    return view;
  }
  CameraPath random_path() {
    CameraPath path;
    path.name = word();
    path.closed = pick(3) == 0;
    for (int i = 2 + pick(6); i > 0; --i) {
      PathKey key;
      key.name = word();
      key.camera = camera();
      key.delay_s = pick(2) ? 0.0 : static_cast<double>(real(0.0f, 2.0f));
      key.duration_s = static_cast<double>(real(0.1f, 3.0f));
      key.ease = static_cast<Ease>(pick(4));
      if (pick(4) == 0) key.env_rotation_deg = real(-360.0f, 360.0f);
      if (pick(4) == 0) key.exposure_ev = real(-5.0f, 5.0f);
      path.keys.push_back(key);
    }
    return path;
  }
  int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  float real(float low, float high) {
    return low + (high - low) * static_cast<float>(random_()) / static_cast<float>(std::mt19937::max());
  }
  glm::vec3 point() { return {real(-9.0f, 9.0f), real(-9.0f, 9.0f), real(-9.0f, 9.0f)}; }
  std::string word() {
    static const std::vector<std::string> kWords = {"paint", "door",       "a/b", "~tilde",
                                                    "x#y",   "\xc3\xbcml", "\"",  "seat"};
    return any_of(kWords);
  }

 private:
  std::string any_of(const std::vector<std::string>& names) {
    return names[static_cast<std::size_t>(pick(static_cast<int>(names.size())))];
  }
  template <typename T, typename Make>
  void change_list(std::vector<T>* list, const Make& make) {
    const int choice = list->size() > 6 ? 0 : pick(4);
    const auto at = list->begin() + (list->empty() ? 0 : pick(static_cast<int>(list->size())));
    if (choice == 0 && !list->empty())
      list->erase(at);
    else if (choice == 1 && list->size() > 1)
      std::swap(list->front(), list->back());
    else
      list->insert(at, make());
  }

  std::mt19937 random_;
  int number_ = 0;
};

}  // namespace maquette::test
