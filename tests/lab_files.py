"""One trial written as laboratories keep it, each format by a library of its own where there is one.

Time in s, channels with a name and a unit; no library writes LabVIEW measurement files: they follow its manual.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Columns = Mapping[str, tuple[Array, str]]
"""Name -> values (n,) and unit."""


def write_csv(path: Path, time: Array, columns: Columns, separator: str = ",", decimal: str = ".") -> None:
    """Text with a header and 12 digits."""
    names = ["time [s]", *(f"{name} [{unit}]" for name, (_, unit) in columns.items())]
    rows = np.column_stack([time, *(values for values, _ in columns.values())])
    lines = [separator.join(names), *(separator.join(f"{v:.12g}" for v in row).replace(".", decimal) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_excel(path: Path, time: Array, columns: Columns) -> None:
    """A title, names, units, then rows, as an exported sheet has them."""
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Trial"
    sheet.append(["Towing tank 2, exported by hand"])
    sheet.append(["time", *columns])
    sheet.append(["s", *(unit for _, unit in columns.values())])
    for row in zip(time, *(values for values, _ in columns.values()), strict=True):
        sheet.append([float(value) for value in row])
    book.save(path)


def write_lvm(path: Path, time: Array, columns: Columns, decimal: str = ".") -> None:
    """LabVIEW measurement file with one X column and 12 digits."""
    head = [
        "LabVIEW Measurement", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
        f"Decimal_Separator\t{decimal}", "Multi_Headings\tNo", "X_Columns\tOne", "Time_Pref\tRelative",
        "***End_of_Header***", "", f"Channels\t{len(columns)}", f"Samples\t{len(time)}",
        "Y_Unit_Label\t" + "\t".join(unit for _, unit in columns.values()), "X_Dimension\tTime",
        "X0\t0.0", "Delta_X\t1.0", "***End_of_Header***", "X_Value\t" + "\t".join(columns) + "\tComment",
    ]  # fmt: skip
    rows = zip(time, *(values for values, _ in columns.values()), strict=True)
    body = ["\t".join(f"{value:.12g}" for value in row).replace(".", decimal) for row in rows]
    path.write_text("\n".join([*head, *body]) + "\n", encoding="utf-8")


def write_tdms(path: Path, time: Array, columns: Columns) -> None:
    """TDMS with increments in place of a time channel."""
    import nptdms

    step = float(time[1] - time[0])
    channels = [
        nptdms.ChannelObject("Trial", name, values, {"wf_increment": step, "wf_start_offset": 0.0, "unit_string": unit})
        for name, (values, unit) in columns.items()
    ]
    with nptdms.TdmsWriter(str(path)) as file:
        file.write_segment([nptdms.RootObject({"operator": "A"}), nptdms.GroupObject("Trial"), *channels])


def write_uff(path: Path, time: Array, columns: Columns) -> None:
    """Universal file, data set 58, double precision in text."""
    import pyuff

    file = pyuff.UFF(str(path))
    for number, (name, (values, unit)) in enumerate(columns.items(), 1):
        axes = {
            f"{axis}_{key}": value
            for axis in ("abscissa", "ordinate", "orddenom", "z_axis")
            for key, value in {
                "spec_data_type": 0, "len_unit_exp": 0, "force_unit_exp": 0, "temp_unit_exp": 0,
                "axis_units_lab": "NONE",
            }.items()
        }  # fmt: skip
        axes |= {"abscissa_axis_units_lab": "s", "ordinate_axis_units_lab": unit}
        one = pyuff.prepare_58(
            binary=0, id1=name, id2="NONE", id3="NONE", id4="NONE", id5="NONE", func_type=1, ver_num=0,
            load_case_id=0, rsp_ent_name="NONE", ref_ent_name="NONE", z_axis_value=0.0, rsp_node=number, rsp_dir=1,
            ref_node=0, ref_dir=0, ord_data_type=4, num_pts=time.size, abscissa_spacing=1, abscissa_min=float(time[0]),
            abscissa_inc=float(time[1] - time[0]), data=values, x=time, return_full_dict=True, **axes,
        )  # fmt: skip
        file.write_sets([one], "add")


def write_mdf(path: Path, time: Array, columns: Columns) -> None:
    """MDF 4 with one channel group."""
    import asammdf

    with asammdf.MDF(version="4.10") as file:
        file.append([
            asammdf.Signal(samples=values, timestamps=time, name=name, unit=unit)
            for name, (values, unit) in columns.items()
        ])  # fmt: skip
        file.save(path, overwrite=True)


def write_parquet(path: Path, time: Array, columns: Columns) -> None:
    """Parquet with units in the fields' metadata."""
    import pyarrow.parquet

    pyarrow.parquet.write_table(_arrow(time, columns), path)


def write_feather(path: Path, time: Array, columns: Columns) -> None:
    """Feather version 2 with units in the fields' metadata."""
    import pyarrow.feather

    pyarrow.feather.write_feather(_arrow(time, columns), path, compression="lz4")


def _arrow(time: Array, columns: Columns):
    import pyarrow

    named = {"time": (time, "s"), **columns}
    fields = [pyarrow.field(name, pyarrow.float64(), metadata={"unit": unit}) for name, (_, unit) in named.items()]
    return pyarrow.table([values for values, _ in named.values()], schema=pyarrow.schema(fields))


def write_hdf5(path: Path, time: Array, columns: Columns) -> None:
    """A group of datasets with their units as attributes, and a scalar beside them."""
    import h5py

    with h5py.File(path, "w") as file:
        file["operator"] = "A"
        group = file.create_group("trial")
        for name, (values, unit) in {"time": (time, "s"), **columns}.items():
            dataset = group.create_dataset(name, data=values, compression="gzip")
            dataset.attrs["unit"] = unit


def write_mat(path: Path, time: Array, columns: Columns) -> None:
    """MAT version 5, names with their units, a scalar and a text beside them."""
    import scipy.io

    vectors = {f"{name}_{unit.replace('/', 'p').replace('^', '')}": values for name, (values, unit) in columns.items()}
    scipy.io.savemat(path, {"time_s": time, **vectors, "g": 9.81, "note": "by hand"}, do_compression=True)


def write_mat73(path: Path, time: Array, columns: Columns) -> None:
    """MAT version 7.3: HDF5 behind MATLAB's header, with a scalar beside the vectors."""
    import h5py

    named = {f"{name}_{unit.replace('/', 'p').replace('^', '')}": values for name, (values, unit) in columns.items()}
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"time_s": time, **named, "g": np.array([9.81])}.items():
            dataset = file.create_dataset(name, data=np.atleast_2d(values))
            dataset.attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(124) + b"\x00\x02IM")


Writer = Callable[[Path, Array, Columns], None]

WRITERS: Mapping[str, Writer] = {
    "r.csv": write_csv, "r.xlsx": write_excel, "r.lvm": write_lvm, "r.tdms": write_tdms, "r.uff": write_uff,
    "r.mf4": write_mdf, "r.parquet": write_parquet, "r.feather": write_feather, "r.h5": write_hdf5, "r.mat": write_mat,
    "r73.mat": write_mat73,
}  # fmt: skip
"""File name -> who writes it."""
