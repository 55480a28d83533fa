import js from "@eslint/js";
import tseslint from "typescript-eslint";

export default tseslint.config(
  { ignores: ["dist", "node_modules"] },
  js.configs.recommended,
  ...tseslint.configs.strict,
  {
    files: ["src/**/*.ts"],
    rules: {
      // Texts of others are set as text: nothing here may make markup of them.
      "no-restricted-properties": [
        "error",
        ...["innerHTML", "outerHTML", "insertAdjacentHTML"].map((property) => ({
          property,
          message: "set text as text",
        })),
      ],
      "no-restricted-syntax": [
        "error",
        { selector: "AssignmentExpression[left.property.name=/^(innerHTML|outerHTML)$/]", message: "set text as text" },
        {
          selector: "CallExpression[callee.property.name=/^(insertAdjacentHTML|write|writeln)$/]",
          message: "set text as text",
        },
      ],
      "no-eval": "error",
      eqeqeq: "error",
      "@typescript-eslint/no-non-null-assertion": "error",
    },
  },
  {
    files: ["**/*.mjs"],
    languageOptions: {
      globals: {
        process: "readonly",
        console: "readonly",
        URL: "readonly",
        fetch: "readonly",
        setTimeout: "readonly",
        performance: "readonly",
        WebSocket: "readonly",
        document: "readonly",
        innerWidth: "readonly",
        Event: "readonly",
        getComputedStyle: "readonly",
      },
    },
    rules: { "no-empty": "off", "no-unused-expressions": "off", "@typescript-eslint/no-unused-expressions": "off" },
  },
);
