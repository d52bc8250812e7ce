// What dynemo-query answers, for people and for programs.
#pragma once

#include <string>
#include <vector>

#include "dynemo/query/scene_query.h"
#include "dynemo/query/session_difference.h"

namespace dynemo {

/// Times are given as UNIX seconds and in seconds after `begin`.
std::string whereText(const Whereabouts& w, Stamp at, Stamp begin);
std::string whereJson(const Whereabouts& w, Stamp at);

std::string movedText(const std::vector<Move>& moves, Stamp begin);
std::string movedJson(const std::vector<Move>& moves);

std::string nearText(const std::vector<Whereabouts>& found, const Vector3& p_map, Stamp begin);
std::string nearJson(const std::vector<Whereabouts>& found, const Vector3& p_map, Stamp at);

std::string trackText(const std::vector<Sighting>& track, Stamp begin);
std::string trackJson(const std::vector<Sighting>& track, const Whereabouts& entity);

std::string entitiesText(const std::vector<Whereabouts>& all, Stamp begin);
std::string entitiesJson(const std::vector<Whereabouts>& all, Stamp at);

std::string differenceText(const SessionDifference& difference);
std::string differenceJson(const SessionDifference& difference);

}  // namespace dynemo
