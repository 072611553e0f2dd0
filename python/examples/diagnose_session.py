"""What the model of a robot leaves out of a measured session: python diagnose_session.py my-session results"""

import sys

import stiffbench


def report(session, out):
    """The verdict, and what was found with its size."""
    readings = stiffbench.readings(session)
    counted = readings[readings["status"] == "accepted"]
    result = stiffbench.diagnose(session, out=out, no_figures=True)
    data = result["data"]
    lines = [f"{len(counted)} readings in {counted.groupby(['pose', 'direction']).ngroups} cells"]
    lines.append(f"verdict: {data['verdict']}")
    lines.append(data["headline"])
    for finding in data["findings"]:
        place = ", ".join(str(part) for part in (finding["place"] or {}).values())
        for name, size in finding["parameters"].items():
            lines.append(f"{finding['physics']} at {place}: {name} = {size['value']:.4g} {size['unit']}, 95 % {size['ci95']}")
    return "\n".join(lines)


if __name__ == "__main__":
    print(report(sys.argv[1], sys.argv[2]))
