"""Reads the files of a result folder with VTK and Apache Arrow and compares them with its CSV tables.

usage: check_exchange.py FOLDER

The folder is written by `kinetostat run STUDY --format csv,parquet,vti`. Numbers must agree to 1e-12, relative; grid
positions of an image to its single precision. Ends with 1 and says where if they do not.
"""

import csv
import json
import math
import sys
from pathlib import Path

import pyarrow.parquet
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLImageDataReader

RELATIVE = 1e-12
SINGLE = 1e-6


def fail(message):
    sys.exit(f"{message}")


def same(found, expected, what):
    if not math.isclose(found, expected, rel_tol=RELATIVE, abs_tol=0.0):
        fail(f"{what}: {found!r}, expected {expected!r}")


def check_parquet(file, rows, columns):
    table = pyarrow.parquet.read_table(file)
    metadata = {key.decode(): value.decode() for key, value in table.schema.metadata.items()}
    if metadata["kinetostat.schema"] != "3":
        fail(f"{file}: schema {metadata['kinetostat.schema']}")
    if table.column_names != [column["titles"] for column in columns]:
        fail(f"{file}: columns {table.column_names}")
    for column in columns:
        name = column["titles"]
        if metadata.get(f"unit.{name}") != column.get("schema:unitText"):
            fail(f"{file}: unit of {name}")
        for index, (found, row) in enumerate(zip(table[name].to_pylist(), rows, strict=True)):
            cell = row[name]
            if cell == "" or column["datatype"] == "string":
                if (found or "") != cell:
                    fail(f"{file}: row {index}, {name}: {found!r}, expected {cell!r}")
            else:
                same(found, float(cell), f"{file}: row {index}, {name}")
    return len(rows) * len(columns)


def read_image(file):
    reader = vtkXMLImageDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    if reader.GetErrorCode():
        fail(f"{file}: VTK cannot read it")
    return reader.GetOutput()


def layers(folder, tables):
    """Rows of each grid point by the label of their arrays."""
    keys = {"map.csv": ["source"] if "source" in tables["map.csv"][0] else ["sum", "followed"], "safe_load.csv": []}
    for name, key in keys.items():
        by_label = {}
        for row in tables.get(name, []):
            label = "/".join(row[column] for column in key) or name.removesuffix(".csv")
            by_label.setdefault(label, []).append(row)
        yield from by_label.items()


def check_image(folder, tables):
    image, described = read_image(folder / "map.vti"), json.loads((folder / "map.vti.json").read_text())
    points = image.GetPointData()
    names = [points.GetArrayName(index) for index in range(points.GetNumberOfArrays())]
    if names != [array["name"] for array in described["arrays"]]:
        fail(f"arrays {names}")
    if list(image.GetDimensions()) != described["points"]:
        fail(f"dimensions {image.GetDimensions()}")
    positions = vtk_to_numpy(points.GetArray("position_mm"))
    compared, seen = 0, {"position_mm"}
    for label, rows in layers(folder, tables):
        if len(rows) != image.GetNumberOfPoints():
            fail(f"{label}: {image.GetNumberOfPoints()} points, {len(rows)} rows")
        for index, row in enumerate(rows):
            for axis, column in enumerate(["x_mm", "y_mm", "z_mm"]):
                same(positions[index][axis], float(row[column]), f"position {index}")
                if abs(image.GetPoint(index)[axis] - float(row[column])) > SINGLE * max(map(abs, image.GetBounds())):
                    fail(f"point {index} lies at {image.GetPoint(index)}")
        for column in [column for column in ["status", "correction_status"] if column in rows[0]]:
            name = f"{label}/{column}"
            statuses = vtk_to_numpy(points.GetArray(name))
            for index, row in enumerate(rows):
                if statuses[index] != described["status"][row[column]]:
                    fail(f"{name}: point {index}")
            seen.add(name)
        for name in [name for name in names if name.startswith(f"{label}/") and name not in seen]:
            seen.add(name)
            quantity, values = name.removeprefix(f"{label}/"), vtk_to_numpy(points.GetArray(name))
            columns = [quantity]
            if quantity.endswith("_vector_mm"):
                columns = [quantity.replace("_vector_mm", f"_{axis}_mm") for axis in "xyz"]
            for index, row in enumerate(rows):
                found = values[index] if len(columns) == 3 else [values[index]]
                for number, column in zip(found, columns, strict=True):
                    compared += 1
                    if row[column] == "":
                        if not math.isnan(number):
                            fail(f"{name}: point {index} has {number}, the table nothing")
                    else:
                        same(number, float(row[column]), f"{name}: point {index}")
    if seen != set(names):
        fail(f"arrays without a table: {set(names) - seen}")
    return compared


def main():
    folder = Path(sys.argv[1])
    description = json.loads((folder / "csv-metadata.json").read_text())
    tables, compared = {}, 0
    for table in description["tables"]:
        with open(folder / table["url"], newline="", encoding="utf-8") as file:
            tables[table["url"]] = list(csv.DictReader(file))
        parquet = (folder / table["url"]).with_suffix(".parquet")
        compared += check_parquet(parquet, tables[table["url"]], table["tableSchema"]["columns"])
    print(f"{compared} cells of {len(tables)} Parquet files agree")
    if (folder / "map.vti").exists():
        compared = check_image(folder, tables)
        if compared == 0:
            fail("an image without numbers")
        print(f"{compared} numbers of map.vti agree")


main()
