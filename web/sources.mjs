// SHA-256 of what the engine is made of: the sources that it uses, without their tests and lines that are comments, and the versions of what
// they use. tests/it/engine_asset.rs computes the same.
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, statSync } from "node:fs";
import { fileURLToPath } from "node:url";

const root = fileURLToPath(new URL("..", import.meta.url));
// Of src, what the feature `study` leaves out, and texts for people.
const apart = (path) => /^src\/(report|cli)(\/|$)|^src\/main\.rs$|^src\/cases\.rs$|\/report(\/|\.rs$)|\/template(\/|$)/.test(path);
function files(folder) {
  return readdirSync(root + folder).flatMap((name) => {
    const path = `${folder}/${name}`;
    if (apart(path)) return [];
    if (statSync(root + path).isDirectory()) return files(path);
    return /\.(rs|toml)$/.test(name) ? [path] : [];
  });
}
const own = ["web/Cargo.toml", "web/Cargo.lock", "web/package.json", "web/build.sh", "web/.cargo/config.toml"];
const all = [...files("crates"), ...files("src"), ...files("web/src"), ...files("web/clock"), ...own].sort();
const hash = createHash("sha256");
for (const path of all) {
  const lines = readFileSync(root + path, "utf8").split("\n#[cfg(test)]\nmod tests {")[0].split("\n").map((line) => line.trim());
  const code = lines.filter((line) => line !== "" && !line.startsWith("//") && !line.startsWith("#!") && !/^# /.test(line));
  hash.update(`${path}\n${code.join("\n")}\n`);
}
console.log(hash.digest("hex"));
