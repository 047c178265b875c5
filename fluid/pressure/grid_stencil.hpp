#pragma once
// Places of a Cartesian grid and of the 3^D around each of them.

#include <array>

namespace tern::fluid {

template <int D>
int flat_index(const std::array<int, D>& coordinate, const std::array<int, D>& size) {
  int index = coordinate[D - 1];
  for (int c = D - 2; c >= 0; --c) index = index * size[c] + coordinate[c];
  return index;
}

/// Coordinates of the place with this flat index.
template <int D>
std::array<int, D> coordinate_of(int flat, const std::array<int, D>& size) {
  std::array<int, D> coordinate;
  for (int c = 0; c < D; ++c, flat /= size[c - 1]) coordinate[c] = flat % size[c];
  return coordinate;
}

template <int D>
int count_places(const std::array<int, D>& size) {
  int count = 1;
  for (int c = 0; c < D; ++c) count *= size[c];
  return count;
}

inline int wrapped(int index, int size, bool periodic) {
  if (!periodic) return index;
  return index < 0 ? index + size : index >= size ? index - size : index;
}

/// Flat index of the place at a coordinate, wrapped where the grid is periodic; -1 outside.
template <int D>
int place_at(std::array<int, D> coordinate, const std::array<int, D>& size, const std::array<bool, D>& periodic) {
  for (int c = 0; c < D; ++c) {
    coordinate[c] = wrapped(coordinate[c], size[c], periodic[c]);
    if (coordinate[c] < 0 || coordinate[c] >= size[c]) return -1;
  }
  return flat_index<D>(coordinate, size);
}

/// Offset in {-1, 0, 1}^D of stencil entry s.
template <int D>
std::array<int, D> stencil_offset(int s) {
  std::array<int, D> offset;
  for (int c = 0; c < D; ++c, s /= 3) offset[c] = s % 3 - 1;
  return offset;
}

/// Stencil entry of an offset.
template <int D>
int stencil_entry(const std::array<int, D>& offset) {
  int entry = offset[D - 1] + 1;
  for (int c = D - 2; c >= 0; --c) entry = entry * 3 + offset[c] + 1;
  return entry;
}

/// Step from a place to a neighbouring one, the short way round where the grid closes on itself.
template <int D>
std::array<int, D> step_between(const std::array<int, D>& from, const std::array<int, D>& to, const std::array<int, D>& size) {
  std::array<int, D> step;
  for (int c = 0; c < D; ++c) {
    step[c] = to[c] - from[c];
    if (step[c] > 1) step[c] -= size[c];
    if (step[c] < -1) step[c] += size[c];
  }
  return step;
}

}  // namespace tern::fluid
