#!/usr/bin/env python3
"""Holds the outputs of detune, and the example files of this repository, against their schemas.

    python3 tests/validate_outputs.py target/release/detune

Needs jsonschema-rs and PyYAML. JSON and JUnit come from every job under jobs/; SARIF is held against the schema
of the standard, tests/data/sarif. Every check is also run on a document that is broken on purpose, so that a
validator that accepts everything cannot pass.
"""

import copy
import json
import re
import subprocess
import sys
import tempfile
import urllib.parse
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import yaml
from jsonschema_rs import Draft4Validator, Draft202012Validator, meta

ROOT = Path(__file__).resolve().parent.parent
SARIF_SCHEMA = ROOT / "tests/data/sarif/sarif-schema-2.1.0.json"
PASSES_OR_FAILS = (0, 1)


class Loader(yaml.SafeLoader):
    """YAML 1.2's idea of a number: 1e6 and 2.0e6 are numbers, not words."""


Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$"),
    list("-+0123456789."),
)
# A date stays text, as in YAML 1.2.
Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:timestamp"]
    for first, resolvers in Loader.yaml_implicit_resolvers.items()
}


def run(*arguments):
    ended = subprocess.run([BINARY, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    if ended.returncode not in PASSES_OR_FAILS:
        sys.exit(f"detune {' '.join(arguments)} exited with {ended.returncode}:\n{ended.stderr}")
    return ended


def must_hold(validator, document, what):
    errors = [(list(map(str, error.instance_path)), error.message) for error in validator.iter_errors(document)]
    if errors:
        told = "\n".join(f"  {'.'.join(path)}: {message}" for path, message in sorted(errors)[:10])
        sys.exit(f"{what} does not hold against its schema:\n{told}")
    print(f"ok  {what}")


def must_not_hold(validator, document, what):
    if validator.is_valid(document):
        sys.exit(f"the schema accepts a broken document: {what}")


def schema_of(name):
    schema = json.loads(run("schema", name).stdout)
    meta.validate(schema)
    return Draft202012Validator(schema)


def check_outputs(jobs):
    check, sarif = schema_of("check"), Draft4Validator(json.loads(SARIF_SCHEMA.read_text()))
    results = 0
    for arguments in [[job] for job in jobs] + [jobs]:
        named = " ".join(arguments)
        ended = {form: run("check", "--format", form, *arguments) for form in ("json", "sarif", "junit")}
        codes = {form: one.returncode for form, one in ended.items()}
        if len(set(codes.values())) != 1:
            sys.exit(f"{named}: the exit code depends on the format: {codes}")

        output = json.loads(ended["json"].stdout)
        must_hold(check, output, f"check --format json {named}")
        broken = copy.deepcopy(output)
        broken["jobs"][0]["operations"][0]["spindle_rpm"] = "fast"
        must_not_hold(check, broken, "spindle_rpm is a word")

        log = json.loads(ended["sarif"].stdout)
        must_hold(sarif, log, f"check --format sarif {named}")
        broken = copy.deepcopy(log)
        broken["runs"][0]["tool"]["driver"]["rules"][0]["level"] = "error"
        must_not_hold(sarif, broken, "a rule has no level")
        results += len(log["runs"][0]["results"])
        for result in log["runs"][0]["results"]:
            for location in result["locations"]:
                points_at_a_line(location["physicalLocation"])

        suites = ElementTree.fromstring(ended["junit"].stdout)
        cases = len(suites.findall("./testsuite/testcase"))
        operations = sum(len(job["operations"]) for job in output["jobs"])
        if cases != operations:
            sys.exit(f"check --format junit {named}: {cases} cases for {operations} operations")
    if results == 0:
        sys.exit("no job under jobs/ has a finding: SARIF results were not looked at")


def advice_outputs(jobs):
    advice = schema_of("advice")
    for job in jobs:
        for more in ([], ["--schedule"], ["--objective", "margin"]):
            output = json.loads(run("advise", "--format", "json", job, *more).stdout)
            must_hold(advice, output, " ".join(["advise --format json", job, *more]))
            broken = copy.deepcopy(output)
            broken["operations"][0]["status"] = "perhaps"
            must_not_hold(advice, broken, "a status that is none")


def points_at_a_line(place):
    region = place["region"]
    file = ROOT / urllib.parse.unquote(place["artifactLocation"]["uri"])
    lines = len(file.read_bytes().splitlines())
    if not 1 <= region["startLine"] <= region["endLine"] <= lines:
        sys.exit(f"{file} has {lines} lines, a result points at {region}")


def check_identifications(sessions):
    validator = schema_of("identification")
    for session in sessions:
        output = json.loads(run("identify", "--format", "json", session).stdout)
        must_hold(validator, output, f"identify --format json {session}")
        broken = copy.deepcopy(output)
        broken["poses"][0]["modes"][0]["frequency_hz"] = None
        must_not_hold(validator, broken, "a frequency is null")
        drawing = run("identify", "--format", "svg", session).stdout
        if ElementTree.fromstring(drawing).tag != "{http://www.w3.org/2000/svg}svg" or "NaN" in drawing:
            sys.exit(f"identify --format svg {session} is no drawing")


def check_diagnoses(robot, tables):
    diagnosis = schema_of("diagnosis")
    for table in tables:
        # Every other row: the output has the same form, in less than half the time.
        header, *rows = [line for line in (ROOT / table).read_text().splitlines() if line[0] != "#"]
        with tempfile.TemporaryDirectory() as folder:
            few = Path(folder) / "few.csv"
            few.write_text("\n".join([header, *rows[::2]]) + "\n")
            output = json.loads(run("diagnose", robot, str(few), "--format", "json").stdout)
        must_hold(diagnosis, output, f"diagnose --format json {robot} {table}")
        broken = copy.deepcopy(output)
        broken["findings"][0]["parameters"][0]["ci95"] = [0, 1, 2]
        must_not_hold(diagnosis, broken, "an interval of three numbers")


def check_files(name, files):
    validator = schema_of(name)
    for file in files:
        text = (ROOT / file).read_text()
        document = yaml.load(text, Loader)
        must_hold(validator, document, file)
        must_not_hold(validator, {**document, "unknown_key": 1}, f"{file} with an unknown key")
        if "yaml-language-server: $schema=" not in text:
            sys.exit(f"{file} lacks a yaml-language-server line")


def found(pattern):
    files = sorted(str(file.relative_to(ROOT)) for file in ROOT.glob(pattern))
    if not files:
        sys.exit(f"no file matches {pattern}")
    return files


def main():
    jobs = found("jobs/*.yaml")
    check_outputs(jobs)
    advice_outputs(jobs)
    check_diagnoses("robots/two-link", found("robots/two-link/*.csv"))
    check_files("job", jobs)
    check_files("robot", found("robots/*/robot.yaml"))
    sessions = found("robots/*/session.yaml")
    check_files("session", sessions)
    check_identifications(sessions)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    BINARY = str(Path(sys.argv[1]).resolve())
    main()
