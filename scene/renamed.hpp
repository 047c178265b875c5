#pragma once
// Keys and values of a case file that have another name now, or none. The old ones are still read, with a note that names the new one.

#include <string>
#include <vector>

#include "scene/settings.hpp"

namespace tern {

struct RenamedKey {
  std::string old_path;  ///< "structure.body.modulus"
  std::string new_key;   ///< in the same table: "young_modulus"
};

struct RenamedValue {
  std::string path;  ///< of the key whose value it is: "coupling.algorithm"
  std::string old_value, new_value;
  std::string other_key = {}, other_value = {};  ///< what the old name said besides, as TOML: a key of the same table that is not given
};

/// A key that is read no more, because what it chose is gone.
struct RemovedKey {
  std::string path;
  std::string instead;  ///< what happens now, for the note
};

struct Renames {
  std::vector<RenamedKey> keys;
  std::vector<RenamedValue> values;
  std::vector<RemovedKey> removed = {};
};

/// What a case file may still call by its old name.
const Renames& renames();

/// Gives everything in `document` its present name, and takes out what is gone; one sentence per old name found. An old key from
/// --set replaces the new one. Throws BadInput where a file gives both.
std::vector<std::string> use_present_names(Setting& document, const Renames& list = renames());

}  // namespace tern
