#pragma once
// The members of a state to a file and back, by the list that each class keeps of them:
//
//   template <class Visit, class... Same>
//   static void for_each_field(Visit&& visit, Same&... all) { visit("time", all.time...); ... }
//
//   StateWriter state;               state("fluid", fluid);          state.to_file(path);
//   StateReader state(path);         state("fluid", fluid);
//
// HDF5: a group per class or container, a dataset per number, vector of numbers, or text, all bits kept. A container has its length as
// "size" and its items as 0, 1, 2 ...

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include <Eigen/Core>

#include "base/lanes.hpp"

namespace tern {

/// A class that lists its members.
template <class T>
concept HasFields = requires(T& all) {
  T::for_each_field([](const char*, const auto&) {}, all);
};

/// As what a file holds numbers.
enum class StoredAs { unsigned8, signed32, unsigned32, signed64, unsigned64, real64 };

/// Values that are a fixed count of numbers of one type; `count` = 0: T is no such value.
template <class T>
struct Numbers {
  static constexpr bool is_matrix = requires { T::SizeAtCompileTime; };
  static constexpr std::size_t count_of() {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) return 1;
    if constexpr (std::is_same_v<T, Lanes>) return lane_count;
    if constexpr (is_matrix) return T::SizeAtCompileTime == Eigen::Dynamic ? 0 : static_cast<std::size_t>(T::SizeAtCompileTime);
    return std::is_class_v<T> && sizeof(T) == 1 && !std::is_empty_v<T> ? 1 : 0;  // a byte of marks
  }
  static constexpr StoredAs type_of() {
    if constexpr (std::is_same_v<T, double> || std::is_same_v<T, Lanes> || is_matrix)
      return StoredAs::real64;
    else if constexpr (sizeof(T) == 1)
      return StoredAs::unsigned8;
    else if constexpr (std::is_enum_v<T>)
      return sizeof(T) == 4 ? StoredAs::signed32 : StoredAs::signed64;
    else if constexpr (std::is_signed_v<T>)
      return sizeof(T) == 4 ? StoredAs::signed32 : StoredAs::signed64;
    else
      return sizeof(T) == 4 ? StoredAs::unsigned32 : StoredAs::unsigned64;
  }
  static constexpr std::size_t count = count_of();
  static constexpr StoredAs type = type_of();
  static_assert(!std::is_same_v<T, float> && !std::is_same_v<T, long double>, "only double is stored");
};

/// A dynamic vector of Eigen.
template <class T>
concept DynamicVector = std::same_as<T, Eigen::VectorXd>;

/// Gathers a copy in memory, which to_file() writes.
class StateWriter {
 public:
  /// Forgets what it has gathered, and keeps the memory.
  void clear() {
    entries_.clear();
    bytes_.clear();
  }

  template <class T>
  void operator()(const std::string& name, const T& value) {
    if constexpr (HasFields<T>) {
      T::for_each_field([&](const char* member, const auto& own) { (*this)(name + "/" + member, own); }, value);
    } else if constexpr (std::is_same_v<T, StateWriter>) {
      for (const Entry& entry : value.entries_)
        write(name + "/" + entry.name, entry.type, value.bytes_.data() + entry.begin, entry.rows, entry.columns);
    } else if constexpr (std::is_same_v<T, std::string>) {
      write(name, StoredAs::unsigned8, value.data(), value.size(), 0);
    } else if constexpr (DynamicVector<T>) {
      write(name, StoredAs::real64, value.data(), static_cast<std::size_t>(value.size()), 0);
    } else if constexpr (Numbers<T>::count > 0) {
      write(name, Numbers<T>::type, &value, 1, Numbers<T>::count > 1 ? Numbers<T>::count : 0);
    } else if constexpr (requires { value.has_value(); }) {
      (*this)(name + "/size", std::uint64_t{value.has_value()});
      if (value) (*this)(name + "/0", *value);
    } else if constexpr (requires { typename T::mapped_type; }) {
      (*this)(name + "/size", std::uint64_t{value.size()});
      std::size_t k = 0;
      for (const auto& [key, own] : value) {
        (*this)(fmt::format("{}/{}/key", name, k), key);
        (*this)(fmt::format("{}/{}/value", name, k++), own);
      }
    } else {
      write_items(name, value);
    }
  }

  /// Brings everything to the disk. Throws InputOutputError.
  void to_file(const std::string& path) const;

 private:
  friend class StateReader;
  struct Entry {
    std::string name;
    StoredAs type;
    std::size_t rows, columns, begin;  ///< begin: in bytes_
  };

  template <class Items>
  void write_items(const std::string& name, const Items& items) {
    using Item = typename Items::value_type;
    static_assert(!std::is_same_v<Items, std::vector<bool>>, "no array of numbers");
    if constexpr (std::is_same_v<Items, std::vector<Item>> && Numbers<Item>::count > 0) {
      write(name, Numbers<Item>::type, items.data(), items.size(), Numbers<Item>::count > 1 ? Numbers<Item>::count : 0);
    } else {
      (*this)(name + "/size", std::uint64_t{items.size()});
      std::size_t k = 0;
      for (const Item& item : items) (*this)(name + "/" + std::to_string(k++), item);
    }
  }
  void write(const std::string& name, StoredAs type, const void* values, std::size_t rows, std::size_t columns);

  std::vector<Entry> entries_;
  std::vector<std::byte> bytes_;
};

class StateReader {
 public:
  /// Throws InputOutputError.
  explicit StateReader(const std::string& path);
  ~StateReader();
  StateReader(const StateReader&) = delete;
  StateReader& operator=(const StateReader&) = delete;

  /// Throws BadInput when the file has no such member, or one of another type: it was written by another program.
  template <class T>
  void operator()(const std::string& name, T& value) {
    if constexpr (HasFields<T>) {
      T::for_each_field([&](const char* member, auto& own) { (*this)(name + "/" + member, own); }, value);
    } else if constexpr (std::is_same_v<T, StateWriter>) {
      value = all(name);
    } else if constexpr (std::is_same_v<T, std::string> || DynamicVector<T>) {
      using Index = std::conditional_t<DynamicVector<T>, Eigen::Index, std::size_t>;
      constexpr StoredAs type = DynamicVector<T> ? StoredAs::real64 : StoredAs::unsigned8;
      value.resize(static_cast<Index>(rows(name, type, 0)));
      read(name, type, value.data());
    } else if constexpr (Numbers<T>::count > 0) {
      expect_one(name, rows(name, Numbers<T>::type, Numbers<T>::count > 1 ? Numbers<T>::count : 0));
      read(name, Numbers<T>::type, &value);
    } else if constexpr (requires { value.has_value(); }) {
      value.reset();
      if (size_of(name) > 0) (*this)(name + "/0", value.emplace());
    } else if constexpr (requires { typename T::mapped_type; }) {
      value.clear();
      for (std::size_t k = 0, size = size_of(name); k < size; ++k) {
        typename T::key_type key;
        (*this)(fmt::format("{}/{}/key", name, k), key);
        (*this)(fmt::format("{}/{}/value", name, k), value[key]);
      }
    } else {
      read_items(name, value);
    }
  }

  bool has(const std::string& name);
  /// All members whose names go through `name`, by what follows in them.
  StateWriter all(const std::string& name);

 private:
  template <class Items>
  void read_items(const std::string& name, Items& items) {
    using Item = typename Items::value_type;
    if constexpr (std::is_same_v<Items, std::vector<Item>> && Numbers<Item>::count > 0) {
      items.resize(rows(name, Numbers<Item>::type, Numbers<Item>::count > 1 ? Numbers<Item>::count : 0));
      read(name, Numbers<Item>::type, items.data());
    } else {
      const std::size_t size = size_of(name);
      if constexpr (requires { items.resize(size); }) {
        if constexpr (std::is_default_constructible_v<Item>) {
          items.clear();
          items.resize(size);
        }
      }
      expect_size(name, size, items.size());
      std::size_t k = 0;
      for (Item& item : items) (*this)(name + "/" + std::to_string(k++), item);
    }
  }
  std::size_t size_of(const std::string& name) {
    std::uint64_t size = 0;
    (*this)(name + "/size", size);
    return size;
  }
  /// Rows of a dataset, which has this type and so many columns (0: one number a row).
  std::size_t rows(const std::string& name, StoredAs type, std::size_t columns);
  void read(const std::string& name, StoredAs type, void* values);
  void expect_one(const std::string& name, std::size_t rows) { expect_size(name, rows, 1); }
  void expect_size(const std::string& name, std::size_t found, std::size_t wanted) const;

  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace tern
