#!/usr/bin/env python3
"""Reads a scene graph as spark_dsg would: check_spark_dsg.py FILE.json [entities.csv keyframes.tum].

Checks the JSON Schema beside this file and what spark_dsg's loader demands beyond it; with the other two files, that the
graph holds the same keyframes and observations. Exit status 0 when all is well, 1 with the reason when not, 77 where
python3-jsonschema is missing.
"""
import collections
import csv
import json
import math
import pathlib
import sys

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is missing")
    sys.exit(77)


def require(condition, message):
    if not condition:
        raise SystemExit(message)


def check_invariants(graph):
    layers = [(k["layer"], k["partition"]) for k in graph["layer_keys"]]
    names = [(k["layer"], k["partition"]) for k in graph["layer_names"].values()]
    require(sorted(layers) == sorted(names), "layer_keys and layer_names differ")
    layer_of = {}
    for node in graph["nodes"]:
        key = (node["layer"], node["partition"])
        require(node["id"] not in layer_of, f"node {node['id']} is there twice")
        require(key in layers, f"node {node['id']} is in layer {key}, which is not listed")
        require(chr(node["id"] >> 56).isalpha(), f"node {node['id']} has no letter in its highest byte")
        layer_of[node["id"]] = key
    letters = collections.defaultdict(set)
    for node, key in layer_of.items():
        letters[key].add(node >> 56)
    require(all(len(s) == 1 for s in letters.values()), "a layer mixes letters")
    require(len(set.union(*letters.values(), set())) == len(letters), "two layers share a letter")
    seen = set()
    for edge in graph["edges"]:
        a, b = edge["source"], edge["target"]
        require(a in layer_of and b in layer_of, f"edge {a} {b} names a node that is not there")
        require(a != b, f"edge from {a} to itself")
        require((min(a, b), max(a, b)) not in seen, f"edge {a} {b} is there twice")
        seen.add((min(a, b), max(a, b)))


def unit(q):
    return abs(math.hypot(q["w"], q["x"], q["y"], q["z"]) - 1.0) < 1e-9


def check_nodes(graph):
    for node in graph["nodes"]:
        attributes = node["attributes"]
        for key in ("world_R_object", "world_R_body"):
            require(key not in attributes or unit(attributes[key]), f"node {node['id']}: {key} is no rotation")
        if attributes["type"] != "KhronosObjectAttributes":
            continue
        times = attributes["trajectory_timestamps"]
        require(times == sorted(times) and times, "a trajectory does not ascend")
        require(len(times) == len(attributes["trajectory_positions"]), "a trajectory misses positions")
        require(attributes["position"] == attributes["trajectory_positions"][-1], "an object is not where it was last")
        spans = list(zip(attributes["first_observed_ns"], attributes["last_observed_ns"]))
        require(len(attributes["first_observed_ns"]) == len(attributes["last_observed_ns"]) and spans, "no spans")
        require(all(a <= b for a, b in spans), "a span ends before it begins")
        require(spans[0][0] == times[0] and spans[-1][1] == times[-1], "the spans are not those of the trajectory")


def check_contents(graph, entities_csv, keyframes_tum):
    rows = collections.defaultdict(list)
    for row in csv.DictReader(open(entities_csv, newline="")):
        rows[int(row["entity_id"])].append([float(row[c]) for c in "xyz"])
    objects = {n["attributes"]["metadata"]["entity_id"]: n for n in graph["nodes"]
               if n["attributes"]["type"] == "KhronosObjectAttributes"}
    require(objects.keys() == rows.keys(), "the entities are not those of entities.csv")
    for entity, node in objects.items():
        require(node["id"] == (ord("O") << 56) + entity, f"entity {entity} has id {node['id']}")
        positions = node["attributes"]["trajectory_positions"]
        require(len(positions) == len(rows[entity]), f"entity {entity}: not all observations")
        for p, q in zip(positions, rows[entity]):
            require(math.dist(p, q) < 1e-6, f"entity {entity}: {p} instead of {q}")
    poses = [list(map(float, line.split())) for line in open(keyframes_tum)]
    agents = [n["attributes"] for n in graph["nodes"] if n["attributes"]["type"] == "AgentNodeAttributes"]
    require(len(agents) == len(poses), "the keyframes are not those of keyframes.tum")
    for agent, pose in zip(agents, poses):
        require(abs(agent["timestamp"] * 1e-9 - pose[0]) < 1e-6, "a keyframe has another time")
        require(math.dist(agent["position"], pose[1:4]) < 1e-6, "a keyframe is elsewhere")


def main():
    graph = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    schema = json.loads((pathlib.Path(__file__).parent / "spark_dsg.schema.json").read_text())
    try:
        jsonschema.Draft7Validator(schema).validate(graph)
    except jsonschema.ValidationError as e:
        raise SystemExit(f"{list(e.absolute_path)}: {e.message}")
    check_invariants(graph)
    check_nodes(graph)
    if len(sys.argv) > 2:
        check_contents(graph, sys.argv[2], sys.argv[3])
    print(f"{len(graph['nodes'])} nodes, {len(graph['edges'])} edges")
    return 0


if __name__ == "__main__":
    sys.exit(main())
