"""docs/fleet/statefulset.yaml: valid for Kubernetes, and its commands are ones that the program takes."""

import os
import subprocess
import unittest

import kubernetes_validate
import yaml

SERVER = os.environ["ELITESERVER"]
FILE = os.path.join(os.path.dirname(__file__), "../../docs/fleet/statefulset.yaml")


class StatefulSet(unittest.TestCase):
    def setUp(self):
        with open(FILE) as file:
            self.service, self.set = yaml.safe_load_all(file)
        self.container = self.set["spec"]["template"]["spec"]["containers"][0]

    def test_it_fits_the_schemas_without_a_key_too_many(self):
        for resource in (self.service, self.set):
            kubernetes_validate.validate(resource, "1.31", strict=True)
        broken = {**self.set, "spec": {**self.set["spec"], "replicas": "three"}}
        with self.assertRaises(kubernetes_validate.ValidationError):
            kubernetes_validate.validate(broken, "1.31", strict=True)

    def test_names_ports_and_volumes_belong_together(self):
        spec, labels = self.set["spec"], self.set["spec"]["template"]["metadata"]["labels"]
        self.assertEqual(spec["serviceName"], self.service["metadata"]["name"])
        self.assertEqual(spec["selector"]["matchLabels"], labels)
        self.assertEqual(self.service["spec"]["selector"], labels)
        exposed = {port["name"]: port["port"] for port in self.service["spec"]["ports"]}
        inside = {port["name"]: port["containerPort"] for port in self.container["ports"]}
        self.assertEqual(exposed, inside)
        self.assertIn(self.container["livenessProbe"]["httpGet"]["port"], inside)
        volumes = {claim["metadata"]["name"] for claim in spec["volumeClaimTemplates"]}
        self.assertEqual({mount["name"] for mount in self.container["volumeMounts"]}, volumes)

    def test_its_commands_are_the_programs(self):
        lines = [
            self.container["command"] + self.container["args"],
            self.container["readinessProbe"]["exec"]["command"],
        ]
        for line in lines:
            self.assertEqual(line[0], "eliteserver")
            told = subprocess.run([SERVER, *line[1:], "--help"], capture_output=True, text=True, timeout=60)
            self.assertEqual(told.returncode, 0, told.stderr)
        text = subprocess.run([SERVER, "serve", "--help"], capture_output=True, text=True, timeout=60).stdout
        for argument in self.container["args"][1:]:
            self.assertIn(argument.split("=")[0], text)


if __name__ == "__main__":
    unittest.main()
