"""What a saved benchmark says of the machine: all that matters for speed, and not its name in a network."""


def pytest_benchmark_update_machine_info(machine_info):
    machine_info.pop("node", None)
