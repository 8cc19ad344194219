"""Stand-in for the node of a machine, until the package has one: signs, and the description."""

import hashlib
import sys
from pathlib import Path

from hitab_msgs.msg import MachineFile
from hitab_msgs.srv import ReadFiles

from hitab_bringup import described_files, description_digest, read_swarm
from hitab_client import RunFolder
from hitab_core import installed_version
from hitab_machines import MachineSigns
from hitab_ros import Spinner, make_node, names, run


def start(spinning: Spinner) -> None:
    node = make_node("machine")
    spinning.executor.add_node(node)
    machine, swarm, folder = (
        node.declare_parameter(name, "").value for name in ("machine", "swarm", "run_dir")
    )
    spinning.spin_until(lambda: RunFolder(Path(folder)).read() is not None, 60.0)
    record = RunFolder(Path(folder)).read()
    described = read_swarm(Path(record.description))
    files = described_files(described)

    def fill(status):
        status.version, status.description = installed_version(), description_digest(described)

    def read(request, response):
        wanted = request.paths or [*files]
        for path in wanted:
            data = files[path].read_bytes()
            response.files.append(
                MachineFile(
                    path=path,
                    digest=hashlib.sha256(data).hexdigest(),
                    data=data if request.paths else b"",
                )
            )
        response.success = True
        return response

    node.create_service(ReadFiles, names.READ_FILES, read)
    MachineSigns(node, record.namespace, swarm, machine, fill)


if __name__ == "__main__":
    sys.exit(run(start))
